// What a tile source is: read from TileJSON 3.0 with a member "perigee" beside the standard ones.
//   tiles        one or more URL templates (the first counts): {z} {x} {y}, {-y} counted from the
//                south, or {TileMatrix} {TileCol} {TileRow} as WMTS has them; relative ones count
//                from the document
//   scheme       "xyz" (default) or "tms": rows from the south
//   minzoom, maxzoom, bounds (W,S,E,N degrees), name, attribution
//   encoding     heights: "terrarium" or "terrain-rgb" ("mapbox"); 0, 0, 0 or alpha 0: no data
//   tileSize     256 (default) or another power of two, 64 to 1024
//   perigee      {"layer": "height" | "color" | "night", "projection": "mercator" | "geographic" |
//                "planet", "ellipsoid": [a, b], "synthesisGain", "heightRange": [min, max],
//                "available": [[zoom, row, first col, last col], ...] in that order}
//   layers       instead of "tiles": several such objects, one a layer
#ifndef PERIGEE_PLANET_SOURCE_SPEC_H
#define PERIGEE_PLANET_SOURCE_SPEC_H

#include <stddef.h>

#include "planet/planet_file.h"
#include "planet/tile_matrix.h"

enum tile_encoding { ENCODING_IMAGE, ENCODING_TERRARIUM, ENCODING_TERRAIN_RGB };

// Stored tiles of one row: columns [first, last].
typedef struct spec_range {
    int zoom, row, first, last;
} spec_range;

typedef struct spec_layer {
    enum tile_layer layer;
    char *url; // template, absolute
    bool from_south;
    tile_matrix matrix;
    enum tile_encoding encoding;
    double west, south, east, north; // rad; all zero: everywhere
    spec_range *ranges;              // sorted; NULL: not said
    size_t range_count;
} spec_layer;

typedef struct source_spec {
    struct planet_meta meta; // max_zoom filled in
    spec_layer layers[LAYER_COUNT];
    int count;
} source_spec;

enum { SPEC_URL_SIZE = 2048 };

// `origin`: URL or path of the document, for messages and relative templates. ERR_FORMAT, with one
// line that names origin and member.
status source_spec_parse(const char *text, size_t size, const char *origin, source_spec *out);

// A URL template as it is given on a command line: Web Mercator tiles of 256, levels 0 to 18.
status source_spec_of_template(const char *url, enum tile_layer layer, source_spec *out);

void source_spec_deinit(source_spec *spec);

// The URL of a tile; y from the north.
void source_spec_url(const spec_layer *layer, int level, int x, int y, char out[SPEC_URL_SIZE]);

#endif
