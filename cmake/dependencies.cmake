# Everything comes from Debian 12 packages; bin/packages lists them.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(glm REQUIRED)
find_package(TBB REQUIRED)
find_package(fmt REQUIRED)
find_package(hwy REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(TinyGLTF REQUIRED)
find_package(CLI11 REQUIRED)
find_package(embree 3 QUIET)
if(NOT embree_FOUND)
  find_package(embree 4 REQUIRED)
endif()

# The package's CMake file exports an include folder of OpenCV that need not exist; pkg-config does not.
pkg_check_modules(OIIO REQUIRED IMPORTED_TARGET OpenImageIO)
pkg_check_modules(polyclipping REQUIRED IMPORTED_TARGET polyclipping)
