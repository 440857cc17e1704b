#include "raster/pages.h"

#include <new>

#include <sys/mman.h>

namespace gnomon {
namespace {

constexpr size_t page = 4096;
constexpr size_t huge_page = size_t{2} << 20;

std::align_val_t alignment_of(size_t bytes) { return std::align_val_t(bytes >= huge_page ? huge_page : page); }

} // namespace

std::byte* allocate_pages(size_t bytes) {
    auto* pages = static_cast<std::byte*>(::operator new[](bytes, alignment_of(bytes)));
    if (bytes >= huge_page) madvise(pages, bytes, MADV_HUGEPAGE);
    return pages;
}

void release_pages(std::byte* pages, size_t bytes) noexcept { ::operator delete[](pages, alignment_of(bytes)); }

} // namespace gnomon
