# Warnings and arithmetic for our own code: errors on warnings, strict IEEE (no contraction), the same bits from GCC and Clang.
add_library(gnomon_warnings INTERFACE)
target_compile_options(gnomon_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror
  -ffp-contract=off -fno-math-errno -fno-trapping-math
  # Short vectors packed from scalars and read back in other pieces stall on store forwarding: a fragment costs twice as much.
  -fno-tree-slp-vectorize)
if(GNOMON_SANITIZE)
  # GCC warns of uninitialised values inside <regex> once sanitizers have rewritten it.
  target_compile_options(gnomon_warnings INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  add_compile_options(-fsanitize=${GNOMON_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${GNOMON_SANITIZE})
endif()

# gnomon_module(NAME LINK public... PRIVATE private...): the library of folder NAME, made of every .cpp under it.
function(gnomon_module name)
  cmake_parse_arguments(arg "" "" "LINK;PRIVATE" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${name}/*.cpp)
  add_library(gnomon-${name} STATIC ${sources})
  add_library(gnomon::${name} ALIAS gnomon-${name})
  list(TRANSFORM arg_LINK REPLACE "^(core|raster|raytrace)$" "gnomon-\\1")
  target_include_directories(gnomon-${name} PUBLIC
    $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}> $<INSTALL_INTERFACE:include/gnomon>)
  target_compile_features(gnomon-${name} PUBLIC cxx_std_20)
  target_link_libraries(gnomon-${name} PUBLIC ${arg_LINK} PRIVATE ${arg_PRIVATE} $<BUILD_INTERFACE:gnomon_warnings>)
  set_target_properties(gnomon-${name} PROPERTIES EXPORT_NAME ${name})
endfunction()
