// core/law/choose.hpp: from the laws of the settings to a compile-time law. Outside every loop.
#pragma once

#include "core/law/contact.hpp"

namespace talus::core {

/// Not inline: kernels compiled for one kind of processor must not bring the code of errors with them.
[[noreturn]] void no_such_law(const char* kind, int number);

template <class Make, class Normal, class Tangential>
auto choose_rolling(const Laws& l) {
    switch (l.rolling) {
    case RollingLaw::none: return Make::template make<ContactLaw<Normal, Tangential, NoRolling>>();
    case RollingLaw::constant: return Make::template make<ContactLaw<Normal, Tangential, ConstantRolling>>();
    case RollingLaw::spring: return Make::template make<ContactLaw<Normal, Tangential, SpringRolling>>();
    }
    no_such_law("rolling", static_cast<int>(l.rolling));
}

template <class Make, class Normal>
auto choose_tangential(const Laws& l) {
    switch (l.tangential) {
    case TangentialLaw::force_rescaled: return choose_rolling<Make, Normal, ForceHistory<true>>(l);
    case TangentialLaw::force: return choose_rolling<Make, Normal, ForceHistory<false>>(l);
    case TangentialLaw::displacement: return choose_rolling<Make, Normal, DisplacementHistory>(l);
    case TangentialLaw::none: return choose_rolling<Make, Normal, Frictionless>(l);
    }
    no_such_law("tangential", static_cast<int>(l.tangential));
}

/// Make::make<Law>() for the ContactLaw that `l` names.
template <class Make>
auto choose_law(const Laws& l) {
    return l.normal == NormalLaw::hertz ? choose_tangential<Make, HertzNormal>(l) : choose_tangential<Make, LinearNormal>(l);
}

} // namespace talus::core
