// Small planet files for the tests of the store, written tile by tile from a function of place.
// Files lie in a new folder under the working directory.
#ifndef PERIGEE_TESTS_PLANET_FIXTURE_H
#define PERIGEE_TESTS_PLANET_FIXTURE_H

#include "planet/planet_writer.h"
#include "planet/pyramid.h"

typedef struct fixture {
    char dir[64], path[96];
} fixture;

// Height at a sample of a tile, NaN where it has none. row, col: of the sample in the tile.
typedef float (*fixture_height)(tile_id id, int row, int col, double lat, double lon);
// Is the tile stored? NULL: all are.
typedef bool (*fixture_choice)(tile_id id);

void fixture_init(fixture *f, const char *name);
void fixture_deinit(fixture *f); // removes the folder with what is in it

// Latitude and longitude of a sample of a tile.
void fixture_place(tile_id id, int row, int col, double *lat, double *lon);

// Puts heights of the chosen tiles, zooms 0 to max_zoom.
void fixture_put_heights(struct planet_writer *w, int max_zoom, fixture_height height,
                         fixture_choice choice);

// A whole file of heights.
void fixture_write(const fixture *f, int max_zoom, double gain, fixture_height height,
                   fixture_choice choice);

// A smooth field, wave numbers up to 4, metres in [-3000, 3000].
double fixture_smooth(double lat, double lon);
float fixture_smooth_height(tile_id id, int row, int col, double lat, double lon);

// Heights with structure at every scale down to the samples of the zoom: all land; and with flat
// sea on the half around the antimeridian.
float fixture_land_height(tile_id id, int row, int col, double lat, double lon);
float fixture_rough_height(tile_id id, int row, int col, double lat, double lon);

// An open file with its pyramid.
typedef struct opened {
    struct planet_file *file;
    struct pyramid *pyramid;
} opened;

opened fixture_open(const fixture *f, size_t cache_bytes, enum synthesis synthesis);
void fixture_close(opened *o);

// Acquires and releases; every failure fails the test.
const pyramid_tile *fixture_get(const opened *o, tile_id id);
void fixture_put_back(const opened *o, const pyramid_tile *tile);

// The tile of heights that holds a point, rad.
tile_id fixture_tile_at(int zoom, double lat, double lon);

// The same of a fixed place: both sides of the antimeridian, the poles, and rows where tiles change
// their width are among them.
enum { FIXTURE_PLACES = 16 };
tile_id fixture_place_tile(int place, int zoom);

#endif
