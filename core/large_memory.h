#pragma once
// Memory for images, targets and tables. Blocks of 2 MiB and more are aligned to huge pages and ask for them: a fresh
// one then costs one page fault in 512, which for passes over images is most of their time.

#include <cstddef>
#include <new>

namespace gnomon {

// At least page-aligned from one page on; not cleared. Throws std::bad_alloc.
void* allocate_large(size_t bytes);
void free_large(void* memory, size_t bytes) noexcept; // of the size it was allocated with

// For std::vector. What is added without a value, as by vector<float, LargeAllocator<float>>(n), is left uninitialized.
template <class T> struct LargeAllocator {
    using value_type = T;

    LargeAllocator() = default;
    template <class U> LargeAllocator(const LargeAllocator<U>&) noexcept {}

    T* allocate(size_t count) {
        if (count > static_cast<size_t>(-1) / sizeof(T)) throw std::bad_array_new_length();
        return static_cast<T*>(allocate_large(count * sizeof(T)));
    }
    void deallocate(T* memory, size_t count) noexcept { free_large(memory, count * sizeof(T)); }

    template <class U> void construct(U* at) { ::new (static_cast<void*>(at)) U; }
    template <class U, class... Arguments> void construct(U* at, Arguments&&... arguments) {
        ::new (static_cast<void*>(at)) U(static_cast<Arguments&&>(arguments)...);
    }

    friend bool operator==(const LargeAllocator&, const LargeAllocator&) { return true; }
};

} // namespace gnomon
