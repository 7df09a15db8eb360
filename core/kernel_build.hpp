// core/kernel_build.hpp: how kernels are compiled.
#pragma once

// Laws, transposes and history rows must be inlined into the loops: as calls they pass vectors through memory, at half the speed.
// Where nobody looks at speed (sanitizers, builds that are not optimised), compiling that takes minutes for nothing.
#if defined(NDEBUG) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define TALUS_FLATTEN [[gnu::flatten]]
// Code for AVX-512 must be inlined whole (see kernel_avx512.cpp), which GCC alone does when told to flatten.
#ifndef __clang__
#define TALUS_EIGHT_LANES 1
#endif
#else
#define TALUS_FLATTEN
#endif
