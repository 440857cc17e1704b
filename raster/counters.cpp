#include "raster/counters.h"

namespace gnomon {

void PassCounters::add(const PassCounters& other) {
    draws += other.draws;
    vertices += other.vertices;
    triangles += other.triangles;
    clipped += other.clipped;
    culled += other.culled;
    fragments_covered += other.fragments_covered;
    fragments_passed += other.fragments_passed;
    fragments_shaded += other.fragments_shaded;
    texels_fetched += other.texels_fetched;
    bytes_read += other.bytes_read;
    bytes_written += other.bytes_written;
    rays += other.rays;
    seconds += other.seconds;
}

} // namespace gnomon
