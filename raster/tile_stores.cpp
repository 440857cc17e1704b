#include "raster/tile_stores.h"

#include <algorithm>

#include "raster/setup.h"

namespace gnomon::detail {

int TileStores::rows_left() const {
    int rows = 0;
    for (const Tile& tile : tiles) rows += tile_side - tile.row;
    return rows;
}

void TileStores::store(int rows) {
    while (rows > 0 && !tiles.empty()) {
        Tile& tile = tiles.back();
        const int last = std::min(tile.row + rows, tile_side);
        if (tile.words)
            store_rows(tile.words, tile.row, last, tile.to, stride, stream);
        else
            fill_rows(cleared, tile.row, last, tile.to, stride, stream);
        rows -= last - tile.row;
        tile.row = last;
        if (last == tile_side) tiles.pop_back();
    }
}

} // namespace gnomon::detail
