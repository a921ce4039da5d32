// One field, turned so that the same piece of it lies at the equator, at 80 N, on the antimeridian
// and at the pole, through the whole import: after reduction each of its waves must have the same
// strength everywhere. The strength is found by least squares on the samples' exact places.
#include "test_import_common.h"

enum { WAVES = 8, UNKNOWNS = 2 * WAVES, FINEST = 3, SAMPLES = TILE_SIZE * TILE_SIZE };

// The waves stand around a place: each has a direction there and so many cycles a sample of zoom 1.
struct field {
    dvec3 up, east, north;
    double cycles[WAVES], turn[WAVES];
};

static struct field field_at(double lat_deg, double lon_deg)
{
    double lat = lat_deg * RAD, lon = lon_deg * RAD;
    struct field f = {.up = {cos(lat) * cos(lon), cos(lat) * sin(lon), sin(lat)},
                      .east = {-sin(lon), cos(lon), 0},
                      .north = {-sin(lat) * cos(lon), -sin(lat) * sin(lon), cos(lat)}};
    for (int i = 0; i < WAVES; i++) {
        f.cycles[i] = 0.05 + 0.05 * (i / 2) * 1.9;
        f.turn[i] = (i % 2 ? 0.3 + M_PI / 2 : 0.3) + 0.5 * (i / 2);
    }
    return f;
}

static double phase(const struct field *f, int i, dvec3 n)
{
    double k = 2 * M_PI * f->cycles[i] / grid_step_lat(1);
    double east = dvec3_dot(f->east, n), north = dvec3_dot(f->north, n);
    return k * (east * cos(f->turn[i]) + north * sin(f->turn[i]));
}

static dvec3 normal(double lat, double lon)
{
    return (dvec3){cos(lat) * cos(lon), cos(lat) * sin(lon), sin(lat)};
}

static const struct field *written;

static double by_waves(int band, double lon, double lat)
{
    (void)band;
    double sum = 0;
    for (int i = 0; i < WAVES; i++) sum += sin(phase(written, i, normal(lat * RAD, lon * RAD)));
    return 100 * sum;
}

// Solves the symmetric a x = b in place.
static void solve(double a[UNKNOWNS][UNKNOWNS + 1])
{
    for (int i = 0; i < UNKNOWNS; i++)
        for (int k = 0; k < UNKNOWNS; k++) {
            if (k == i) continue;
            double q = a[k][i] / a[i][i];
            for (int j = i; j <= UNKNOWNS; j++) a[k][j] -= q * a[i][j];
        }
}

// Strength of each wave in the samples of a zoom within 0.12 rad of the place.
static void measure(struct planet_file *p, int zoom, const struct field *f, double *strength)
{
    static float heights[SAMPLES];
    double a[UNKNOWNS][UNKNOWNS + 1] = {0};
    for (int row = 0; row < grid_rows(zoom); row++)
        for (int col = 0; col < grid_cols(zoom, row); col++) {
            tile_id id = {LAYER_HEIGHT, zoom, row, col};
            assert_int_equal(planet_file_read_height(p, id, heights), OK);
            for (int s = 0; s < SAMPLES; s++) {
                double lat, lon, basis[UNKNOWNS + 1];
                sample_place(id, s, &lat, &lon);
                dvec3 n = normal(lat, lon);
                if (dvec3_dot(n, f->up) < cos(0.12)) continue;
                for (int i = 0; i < WAVES; i++) {
                    basis[2 * i] = sin(phase(f, i, n));
                    basis[2 * i + 1] = cos(phase(f, i, n));
                }
                basis[UNKNOWNS] = (double)heights[s] / 100;
                double area = cos(lat) * grid_coalesce(zoom, row);
                for (int i = 0; i < UNKNOWNS; i++)
                    for (int k = 0; k <= UNKNOWNS; k++) a[i][k] += area * basis[i] * basis[k];
            }
        }
    solve(a);
    for (int i = 0; i < WAVES; i++)
        strength[i] = hypot(a[2 * i][UNKNOWNS] / a[2 * i][2 * i],
                            a[2 * i + 1][UNKNOWNS] / a[2 * i + 1][2 * i + 1]);
}

static void import_at(double lat_deg, double lon_deg, double strength[2][WAVES])
{
    struct field f = field_at(lat_deg, lon_deg);
    written = &f;
    raster_spec s = {.name = "waves.tif",
                     .width = 512 << FINEST,
                     .height = 256 << FINEST,
                     .bands = 1,
                     .type = GDT_Float32,
                     .crs = "EPSG:4326",
                     .value = by_waves};
    memcpy(s.transform, (double[6]){-180, 360.0 / s.width, 0, 90, 0, -180.0 / s.height},
           sizeof s.transform);
    write_raster(&s);
    assert_int_equal(import_heights("w.planet", "waves.tif"), OK);
    struct planet_file *p = open_planet("w.planet");
    measure(p, 1, &f, strength[0]);
    measure(p, 0, &f, strength[1]);
    planet_file_close(&p);
}

static void test_same_spectrum(void **state)
{
    (void)state;
    static const double places[][2] = {{80, 12}, {-71, 180}, {90, 0}};
    double equator[2][WAVES], there[2][WAVES];
    import_at(3, 12, equator);
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        import_at(places[i][0], places[i][1], there);
        for (int zoom = 1; zoom >= 0; zoom--)
            for (int w = 0; w < WAVES; w++) {
                // Beyond half a cycle a sample of zoom 0 there is nothing to compare.
                double cycles = field_at(0, 0).cycles[w] * (zoom ? 1 : 2);
                if (cycles > 0.45) continue;
                double a = equator[1 - zoom][w], b = there[1 - zoom][w];
                print_message("zoom %d, %.3f cycles: equator %.4f, %g N %g E %.4f (%+.2f %%)\n",
                              zoom, cycles, a, places[i][0], places[i][1], b, 100 * (b / a - 1));
                // The pyramid's filter is round to 0.4 %; the first sampling, of rasters whose
                // columns crowd towards the poles, is not: it takes 3 % of east-west waves of 12
                // samples of the raster, which is a twelfth a zoom further up.
                check_near(b / a, 1, zoom ? 0.03 : 0.005);
            }
    }
}

static double chequered(int band, double lon, double lat)
{
    (void)band;
    int x = (int)floor((lon + 180) / 360 * 1024), y = (int)floor((90 - lat) / 180 * 512);
    return (x + y) % 2 ? 255 : 0;
}

// Black and white mixed half and half are the grey of half the light, 188, not 128.
static void test_linear_light(void **state)
{
    (void)state;
    raster_spec s = {.name = "chequered.tif",
                     .width = 1024,
                     .height = 512,
                     .bands = 1,
                     .type = GDT_Byte,
                     .crs = "EPSG:4326",
                     .transform = {-180, 360.0 / 1024, 0, 90, 0, -180.0 / 512},
                     .value = chequered};
    write_raster(&s);
    const char *name = s.name;
    assert_int_equal(import_files("l.planet", 1, (enum tile_layer[]){LAYER_COLOR}, &name), OK);
    struct planet_file *f = open_planet("l.planet");
    assert_int_equal(planet_file_meta(f)->max_zoom[LAYER_COLOR], 1);
    static unsigned char pixels[SAMPLES * 3];
    tile_id id = {LAYER_COLOR, 0, 0, 1};
    assert_int_equal(planet_file_read_pixels(f, id, pixels), OK);
    for (int i = 0; i < 20; i++) check_near(pixels[3 * ((220 + i) * TILE_SIZE + 7 * i)], 188, 4);
    planet_file_close(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_linear_light),
                                       cmocka_unit_test(test_same_spectrum)};
    return cmocka_run_group_tests(tests, make_test_dir, remove_test_dir);
}
