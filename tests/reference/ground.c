#include "ground.h"

#include "check.h"

static ground_sample *current;

static float from_current(tile_id id, int row, int col, double lat, double lon)
{
    (void)lat;
    (void)lon;
    return current(id.zoom, (int64_t)id.row * TILE_SIZE + row, (int64_t)id.col * TILE_SIZE + col);
}

void ground_open(struct ground *g, geo_ellipsoid e, int zoom, ground_sample *sample)
{
    struct planet_writer *w;
    struct planet_meta meta = {.name = "Test", .ellipsoid = e};
    *g = (struct ground){0};
    current = sample;
    fixture_init(&g->files, "reference");
    assert_int_equal(planet_writer_open(g->files.path, "test", false, &w), OK);
    fixture_put_heights(w, zoom, from_current, NULL);
    assert_int_equal(planet_writer_finish(w, &meta), OK);
    planet_writer_close(&w);
    g->planet = fixture_open(&g->files, 0, false);
    if (geo_is_plane(e)) {
        const pyramid_params flat = {.flat = true};
        pyramid_destroy(&g->planet.pyramid);
        assert_int_equal(pyramid_create(g->planet.file, &flat, &g->planet.pyramid), OK);
    }
    g->pool = pool_create(2, 4);
}

void ground_look_from(struct ground *g, const double eye[3], int zoom)
{
    reference_progress silent = {0};
    if (g->field) field_reader_deinit(&g->reader);
    field_destroy(&g->field);
    const field_params params = {.pyramid = g->planet.pyramid,
                                 .zoom = zoom,
                                 .sight = {.eye = {eye[0], eye[1], eye[2]}},
                                 .bicubic = g->bicubic};
    assert_int_equal(field_create(&params, g->pool, &silent, &g->field), OK);
    field_reader_init(&g->reader, g->field, g->planet.pyramid);
}

void ground_close(struct ground *g)
{
    if (g->field) field_reader_deinit(&g->reader);
    field_destroy(&g->field);
    pool_destroy(&g->pool);
    fixture_close(&g->planet);
    fixture_deinit(&g->files);
}

void ground_place(int zoom, int64_t row, int64_t col, double *lat, double *lon)
{
    int64_t width = (int64_t)TILE_SIZE * grid_cols(zoom, (int)(row / TILE_SIZE));
    *lat = M_PI / 2 - M_PI * ((double)row + 0.5) / (double)((int64_t)TILE_SIZE << zoom);
    *lon = 2 * M_PI * (((double)col + 0.5) / (double)width - 0.5);
}
