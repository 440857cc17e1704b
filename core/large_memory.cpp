#include "core/large_memory.h"

#include <sys/mman.h>

namespace gnomon {
namespace {

constexpr size_t page = 4096, huge_page = size_t{2} << 20;

std::align_val_t alignment(size_t bytes) {
    return std::align_val_t(bytes >= huge_page ? huge_page : bytes >= page ? page : alignof(std::max_align_t));
}

} // namespace

void* allocate_large(size_t bytes) {
    void* memory = ::operator new(bytes, alignment(bytes));
    if (bytes >= huge_page) madvise(memory, bytes, MADV_HUGEPAGE);
    return memory;
}

void free_large(void* memory, size_t bytes) noexcept { ::operator delete(memory, alignment(bytes)); }

} // namespace gnomon
