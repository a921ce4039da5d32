#include "planet_fixture.h"

#include <dirent.h>
#include <math.h>
#include <unistd.h>

#include "base/vec.h"
#include "check.h"

void fixture_init(fixture *f, const char *name)
{
    snprintf(f->dir, sizeof f->dir, "%s-XXXXXX", name);
    assert_non_null(mkdtemp(f->dir));
    snprintf(f->path, sizeof f->path, "%s/test.planet", f->dir);
}

void fixture_deinit(fixture *f)
{
    DIR *dir = opendir(f->dir);
    for (struct dirent *e; dir && (e = readdir(dir));) {
        char path[400];
        snprintf(path, sizeof path, "%s/%s", f->dir, e->d_name);
        if (e->d_name[0] != '.') unlink(path);
    }
    if (dir) closedir(dir);
    rmdir(f->dir);
}

void fixture_place(tile_id id, int row, int col, double *lat, double *lon)
{
    double west, south, east, north;
    grid_bounds(id, &west, &south, &east, &north);
    *lat = north + (south - north) * (row + 0.5) / TILE_SIZE;
    *lon = west + (east - west) * (col + 0.5) / TILE_SIZE;
}

static void put(struct planet_writer *w, tile_id id, fixture_height height)
{
    static float samples[TILE_SIZE * TILE_SIZE];
    float min = NAN, max = NAN;
    for (int r = 0; r < TILE_SIZE; r++)
        for (int c = 0; c < TILE_SIZE; c++) {
            double lat, lon;
            fixture_place(id, r, c, &lat, &lon);
            float h = height(id, r, c, lat, lon);
            samples[r * TILE_SIZE + c] = h;
            min = fminf(min, h); // ignores NaN
            max = fmaxf(max, h);
        }
    codec_blob body;
    assert_int_equal(codec_height_encode(samples, &body), OK);
    assert_int_equal(planet_writer_put(w, id, &body, min, max), OK);
    codec_blob_deinit(&body);
}

void fixture_put_heights(struct planet_writer *w, int max_zoom, fixture_height height,
                         fixture_choice choice)
{
    for (int zoom = 0; zoom <= max_zoom; zoom++)
        for (int row = 0; row < grid_rows(zoom); row++)
            for (int col = 0; col < grid_cols(zoom, row); col++) {
                tile_id id = {LAYER_HEIGHT, zoom, row, col};
                if (!choice || choice(id)) put(w, id, height);
            }
}

void fixture_write(const fixture *f, int max_zoom, double gain, fixture_height height,
                   fixture_choice choice)
{
    struct planet_writer *w;
    struct planet_meta meta = {.name = "Test", .ellipsoid = GEO_WGS84, .synthesis_gain = gain};
    assert_int_equal(planet_writer_open(f->path, "fixture", false, &w), OK);
    fixture_put_heights(w, max_zoom, height, choice);
    assert_int_equal(planet_writer_finish(w, &meta), OK);
    planet_writer_close(&w);
}

double fixture_smooth(double lat, double lon)
{
    double x = cos(lat) * cos(lon), y = cos(lat) * sin(lon), z = sin(lat);
    return 1000.0 * (x * y + sin(3.0 * z + x) + cos(4.0 * y - 2.0 * z));
}

float fixture_smooth_height(tile_id id, int row, int col, double lat, double lon)
{
    (void)id;
    (void)row;
    (void)col;
    return (float)fixture_smooth(lat, lon);
}

// Heights with structure at every scale down to the samples of the zoom.
static double rough_waves(int zoom, double lat, double lon)
{
    double x = cos(lat) * cos(lon), y = cos(lat) * sin(lon), z = sin(lat), h = 0.0;
    for (int k = 8; k <= 128 << zoom; k *= 2)
        h += 60000.0 / k * sin(k * x + 1.0) * cos(k * (0.7 * y + 0.6 * z) + k);
    return h;
}

float fixture_land_height(tile_id id, int row, int col, double lat, double lon)
{
    (void)row;
    (void)col;
    return (float)(50000.0 + rough_waves(id.zoom, lat, lon));
}

// The half around the antimeridian is flat sea.
float fixture_rough_height(tile_id id, int row, int col, double lat, double lon)
{
    (void)row;
    (void)col;
    double h = 20000.0 * cos(lat) * cos(lon) + rough_waves(id.zoom, lat, lon);
    return h > 0.0 ? (float)h : 0.0f;
}

opened fixture_open(const fixture *f, size_t cache_bytes, enum synthesis synthesis)
{
    opened o = {0};
    pyramid_params params = {.cache_bytes = cache_bytes, .synthesis = synthesis};
    assert_int_equal(planet_file_open(f->path, &o.file), OK);
    assert_int_equal(pyramid_create(o.file, &params, &o.pyramid), OK);
    return o;
}

void fixture_close(opened *o)
{
    pyramid_destroy(&o->pyramid);
    planet_file_close(&o->file);
}

const pyramid_tile *fixture_get(const opened *o, tile_id id)
{
    const pyramid_tile *tile;
    assert_int_equal(pyramid_acquire(o->pyramid, id, &tile), OK);
    assert_true(tile_id_equal(tile->id, id));
    return tile;
}

void fixture_put_back(const opened *o, const pyramid_tile *tile)
{
    pyramid_release(o->pyramid, &tile);
    assert_null(tile);
}

tile_id fixture_tile_at(int zoom, double lat, double lon)
{
    int row = (int)((M_PI / 2 - lat) / M_PI * grid_rows(zoom));
    row = row < 0 ? 0 : row >= grid_rows(zoom) ? grid_rows(zoom) - 1 : row;
    int cols = grid_cols(zoom, row), col = (int)((lon / (2 * M_PI) + 0.5) * cols);
    return (tile_id){LAYER_HEIGHT, zoom, row, col < 0 ? 0 : col >= cols ? cols - 1 : col};
}

// Both sides of the antimeridian, the poles, and rows where tiles change their width.
static const double places_deg[FIXTURE_PLACES][2] = {
    {0.1, 0.1},       {0.1, 179.99}, {0.1, -179.99}, {45, 7},    {59.9, 20},  {60.1, 20},
    {-60.1, 179.99},  {75, -100},    {75.6, -100},   {82.9, 30}, {89.99, 10}, {89.99, 170},
    {-89.99, -179.9}, {-89.99, 90},  {-46, -72},     {-83, -1}};

tile_id fixture_place_tile(int place, int zoom)
{
    return fixture_tile_at(zoom, places_deg[place][0] * M_PI / 180,
                           places_deg[place][1] * M_PI / 180);
}
