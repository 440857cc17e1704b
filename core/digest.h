#pragma once
// A fingerprint of bytes, to tell whether two runs were given the same: FNV-1a of 64 bits. No protection against
// somebody who wants a collision.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace gnomon {

class Digest {
public:
    void add_bytes(const void* bytes, std::size_t size) {
        const auto* at = static_cast<const unsigned char*>(bytes);
        for (std::size_t i = 0; i < size; ++i) value_ = (value_ ^ at[i]) * 0x100000001b3u;
    }
    // Only of types without padding.
    template <class T>
    requires std::is_trivially_copyable_v<T>
    void add(const T& value) { add_bytes(&value, sizeof value); }
    template <class T> void add_all(std::span<const T> values) {
        add(values.size());
        add_bytes(values.data(), values.size_bytes());
    }
    void add_text(std::string_view text) { add_all(std::span<const char>(text)); }

    std::uint64_t value() const { return value_; }
    std::string text() const; // 16 hexadecimal digits

private:
    std::uint64_t value_ = 0xcbf29ce484222325u;
};

} // namespace gnomon
