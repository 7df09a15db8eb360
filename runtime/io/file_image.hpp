// runtime/io/file_image.hpp: the sparse bytes of a file in memory: what HDF5 itself writes of a file (names, shapes, small values),
// without the room it sets aside for bulk data.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>

namespace talus::runtime {

class FileImage {
public:
    std::uint64_t size() const { return size_; }
    void set_size(std::uint64_t n) { size_ = n; }

    /// Bytes beyond the size extend it.
    void write(std::uint64_t at, const void* data, std::size_t n) {
        size_ = std::max(size_, at + n);
        each_piece(at, n, [&](std::uint64_t page, std::size_t from, std::size_t done, std::size_t count) {
            auto& bytes = pages_[page];
            if (!bytes) bytes = std::make_unique<Page>();
            std::memcpy(bytes->data() + from, static_cast<const std::byte*>(data) + done, count);
        });
    }
    /// Zero where nothing was written.
    void read(std::uint64_t at, void* out, std::size_t n) const {
        each_piece(at, n, [&](std::uint64_t page, std::size_t from, std::size_t done, std::size_t count) {
            std::byte* to = static_cast<std::byte*>(out) + done;
            const auto found = pages_.find(page);
            if (found == pages_.end())
                std::memset(to, 0, count);
            else
                std::memcpy(to, found->second->data() + from, count);
        });
    }
    /// visit(offset, data, bytes) of every page that was written, none beyond the size.
    template <class Visit>
    void each_page(Visit visit) const {
        for (const auto& [page, bytes] : pages_)
            if (page * kPage < size_) visit(page * kPage, bytes->data(), static_cast<std::size_t>(std::min<std::uint64_t>(kPage, size_ - page * kPage)));
    }

private:
    static constexpr std::size_t kPage = 4096;
    using Page = std::array<std::byte, kPage>;

    template <class Piece>
    static void each_piece(std::uint64_t at, std::size_t n, Piece piece) {
        for (std::size_t done = 0; done < n;) {
            const std::uint64_t page = (at + done) / kPage;
            const std::size_t from = (at + done) % kPage, count = std::min(kPage - from, n - done);
            piece(page, from, done, count);
            done += count;
        }
    }

    std::map<std::uint64_t, std::unique_ptr<Page>> pages_;
    std::uint64_t size_ = 0;
};

} // namespace talus::runtime
