// PNG and EXR come back as they were written (EXR through OpenEXRCore's reader), the contact sheet
// shows the frames it should, and what cannot be written is one message and leaves nothing behind.
#include "check.h"

#include <openexr.h>
#include <unistd.h>

#include "app/contact_sheet.h"
#include "app/frame_pattern.h"
#include "app/image_exr.h"
#include "app/image_png.h"
#include "app/output_file.h"
#include "base/log.h"

static int lines;
static char last[1024];

static void count_lines(void *user, enum log_level level, const char *line)
{
    (void)user;
    if (level != LOG_ERROR) return;
    lines++;
    snprintf(last, sizeof last, "%s", line);
}

enum { W = 37, H = 41, PIXELS = W * H }; // neither a multiple of 16 lines nor of 2

static void test_png(void **state)
{
    (void)state;
    static uint8_t rgb[3 * PIXELS], back[3 * PIXELS];
    struct check_random r = {7};
    for (int i = 0; i < 3 * PIXELS; i++) rgb[i] = (uint8_t)check_random_u64(&r);
    const struct image_text texts[] = {{"Software", "Perigee"}, {"Source", "\xc2\xa9 somebody"}};
    int w = 0, h = 0;
    assert_int_equal(image_png_write("test_images.png", W, H, rgb, texts, 2), OK);
    assert_int_equal(access("test_images.png.part", F_OK), -1);
    assert_int_equal(image_png_size("test_images.png", &w, &h), OK);
    assert_int_equal(w, W);
    assert_int_equal(h, H);
    assert_int_equal(image_png_read("test_images.png", W, H, back), OK);
    assert_memory_equal(rgb, back, sizeof rgb);
    lines = 0;
    assert_int_equal(image_png_read("test_images.png", W + 1, H, back), ERR_FORMAT);
    assert_int_equal(lines, 1);
    unlink("test_images.png");
}

static size_t read_all(const char *path, uint8_t *data, size_t size)
{
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    size_t n = fread(data, 1, size, f);
    fclose(f);
    return n;
}

// The file says how its numbers are meant, and a truncated one is refused at every length.
static void test_png_bytes(void **state)
{
    (void)state;
    static uint8_t data[8192];
    uint8_t rgb[3 * 8 * 8] = {0}, back[3 * 8 * 8];
    assert_int_equal(image_png_write("test_bytes.png", 8, 8, rgb, NULL, 0), OK);
    size_t size = read_all("test_bytes.png", data, sizeof data);
    assert_non_null(memmem(data, size, "sRGB", 4));
    for (size_t n = 0; n + 4 < size; n++) {
        FILE *f = fopen("test_bytes.png", "wb");
        fwrite(data, 1, n, f);
        fclose(f);
        lines = 0;
        assert_int_not_equal(image_png_read("test_bytes.png", 8, 8, back), OK);
        assert_int_equal(lines, 1);
    }
    unlink("test_bytes.png");
}

static void test_unwritable(void **state)
{
    (void)state;
    uint8_t rgb[3] = {0};
    lines = 0;
    assert_int_equal(image_png_write("no-such-folder/a.png", 1, 1, rgb, NULL, 0), ERR_IO);
    assert_int_equal(lines, 1);
    assert_non_null(strstr(last, "no-such-folder/a.png"));
    assert_int_equal(output_check("no-such-folder/a.png"), ERR_IO);
    assert_int_equal(output_check("."), ERR_IO);
    assert_int_equal(output_check("./"), ERR_IO);
    assert_int_equal(output_check(""), ERR_IO);
    assert_int_equal(lines, 5);
    assert_int_equal(output_check("test-new-file"), OK);
    assert_int_equal(access("test-new-file", F_OK), -1);
}

struct truth {
    float f[6][PIXELS];
    double lat[PIXELS], lon[PIXELS];
};

static struct truth *truth_make(void)
{
    static struct truth t;
    struct check_random r = {11};
    for (int i = 0; i < PIXELS; i++) {
        for (int c = 0; c < 6; c++) t.f[c][i] = (float)check_random_range(&r, -1, 5);
        t.lat[i] = check_random_range(&r, -90, 90);
        t.lon[i] = check_random_range(&r, -180, 180);
    }
    t.f[3][0] = NAN; // a pixel of sky
    t.lat[0] = t.lon[0] = NAN;
    t.f[5][0] = -1;
    return &t;
}

// One channel of a scanline EXR as floats, read by OpenEXRCore.
static void read_channel(const char *path, const char *name, float *out)
{
    exr_context_t c = NULL;
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    assert_int_equal(exr_start_read(&c, path, NULL), 0);
    int found = 0;
    for (int y = 0; y < H; y += 16) {
        exr_chunk_info_t chunk;
        assert_int_equal(exr_read_scanline_chunk_info(c, 0, y, &chunk), 0);
        if (y == 0) assert_int_equal(exr_decoding_initialize(c, 0, &chunk, &pipe), 0);
        else assert_int_equal(exr_decoding_update(c, 0, &chunk, &pipe), 0);
        for (int i = 0; i < pipe.channel_count; i++) {
            exr_coding_channel_info_t *info = &pipe.channels[i];
            info->decode_to_ptr = NULL;
            if (strcmp(info->channel_name, name) != 0) continue;
            found = 1;
            info->decode_to_ptr = (uint8_t *)(out + (size_t)y * W);
            info->user_data_type = EXR_PIXEL_FLOAT;
            info->user_bytes_per_element = 4;
            info->user_pixel_stride = 4;
            info->user_line_stride = 4 * W;
        }
        if (y == 0) assert_int_equal(exr_decoding_choose_default_routines(c, 0, &pipe), 0);
        assert_int_equal(exr_decoding_run(c, 0, &pipe), 0);
    }
    exr_decoding_destroy(c, &pipe);
    exr_finish(&c);
    if (!found) fail_msg("no channel %s", name);
}

static image_exr exr_of(struct truth *t, bool half)
{
    return (image_exr){
        .width = W,
        .height = H,
        .planes = {t->f[0], t->f[1], t->f[2], t->f[3], t->f[4], t->lat, t->lon, t->f[5]},
        .half_color = half,
        .camera = {1, 2, 3, 4, 5, 6, 7},
        .planet = "Earth",
        .attribution = "somebody",
        .zoom = "5 to 13"};
}

static void test_exr(void **state)
{
    (void)state;
    struct truth *t = truth_make();
    static float got[PIXELS], low[PIXELS];
    static const char *const names[] = {"R", "G", "B", "Z", "height", "level"};
    image_exr image = exr_of(t, false);
    image.easting = t->lat;
    image.northing = t->lon;
    for (int i = 0; i < 3; i++) image.normals[i] = t->f[i];
    assert_int_equal(image_exr_write("test_images.exr", &image), OK);
    assert_int_equal(access("test_images.exr.part", F_OK), -1);
    for (int c = 0; c < 6; c++) {
        read_channel("test_images.exr", names[c], got);
        assert_memory_equal(got, t->f[c], sizeof got);
    }
    const double *wide[] = {t->lat, t->lon, t->lat, t->lon};
    static const char *const high_names[] = {"lat", "lon", "easting", "northing"},
                             *const low_names[] = {"lat.lo", "lon.lo", "easting.lo", "northing.lo"};
    for (int k = 0; k < 4; k++) {
        read_channel("test_images.exr", high_names[k], got);
        read_channel("test_images.exr", low_names[k], low);
        assert_true(isnan(got[0]));
        // Two floats hold 48 bits: 180 * 2^-49 = 3e-13 degrees.
        for (int i = 1; i < PIXELS; i++)
            check_near((double)got[i] + (double)low[i], wide[k][i], 1e-12);
    }
    exr_context_t c = NULL;
    double pitch = 0;
    int32_t length;
    const char *text;
    assert_int_equal(exr_start_read(&c, "test_images.exr", NULL), 0);
    assert_int_equal(exr_attr_get_double(c, 0, "camera.pitch", &pitch), 0);
    check_near(pitch, 5, 0);
    assert_int_equal(exr_attr_get_string(c, 0, "attribution", &length, &text), 0);
    assert_string_equal(text, "somebody");
    exr_finish(&c);
    unlink("test_images.exr");
}

static void test_exr_half(void **state)
{
    (void)state;
    struct truth *t = truth_make();
    static float got[PIXELS];
    image_exr image = exr_of(t, true);
    assert_int_equal(image_exr_write("test_half.exr", &image), OK);
    read_channel("test_half.exr", "G", got);
    for (int i = 0; i < PIXELS; i++) // half has 11 bits, values reach 5: half a step of 2^-8
        check_near((double)got[i], (double)t->f[1][i], 0.5 / 256);
    read_channel("test_half.exr", "height", got);
    assert_memory_equal(got, t->f[4], sizeof got);
    unlink("test_half.exr");
    lines = 0;
    assert_int_equal(image_exr_write("no-such-folder/a.exr", &image), ERR_IO);
    assert_int_equal(lines, 1);
}

static void test_exr_read(void **state)
{
    (void)state;
    struct truth *t = truth_make();
    image_exr image = exr_of(t, false);
    image_exr_file f;
    for (int k = 0; k < 3; k++) image.normals[k] = t->f[k];
    assert_int_equal(image_exr_write("test_read.exr", &image), OK);
    assert_int_equal(image_exr_read("test_read.exr", &f), OK);
    assert_int_equal(f.width, W);
    assert_int_equal(f.height, H);
    const float *got[] = {f.r, f.g, f.b, f.z_m, f.height_m, f.level};
    for (int c = 0; c < 6; c++) assert_memory_equal(got[c], t->f[c], sizeof t->f[c]);
    for (int c = 0; c < 3; c++) assert_memory_equal(f.normals[c], t->f[c], sizeof t->f[c]);
    assert_true(isnan(f.lat_deg[0]) && isnan(f.lon_deg[0]));
    for (int i = 1; i < PIXELS; i++) {
        check_near(f.lat_deg[i], t->lat[i], 1e-12);
        check_near(f.lon_deg[i], t->lon[i], 1e-12);
    }
    assert_true(f.has_camera);
    check_near(f.camera.alt_m + f.camera.fov_deg, 3 + 7, 0);
    assert_string_equal(f.planet, "Earth");
    image_exr_file_deinit(&f);
    unlink("test_read.exr");
}

static void expect_unreadable(const char *path, status want, const char *words)
{
    image_exr_file f;
    lines = 0;
    assert_int_equal(image_exr_read(path, &f), want);
    if (lines != 1 || !strstr(last, path) || !strstr(last, words))
        fail_msg("%d lines, '%s' not in: %s", lines, words, last);
    assert_null(f.z_m);
}

// Cut at any length, not an EXR, not there, without depth: one message each.
static void test_exr_unreadable(void **state)
{
    (void)state;
    static uint8_t data[1 << 17];
    struct truth *t = truth_make();
    image_exr image = exr_of(t, false);
    assert_int_equal(image_exr_write("test_cut.exr", &image), OK);
    size_t size = read_all("test_cut.exr", data, sizeof data);
    assert_true(size > 10000 && size < sizeof data);
    for (size_t n = 0; n < size; n += n < 1500 ? 13 : 997) {
        FILE *f = fopen("test_cut.exr", "wb");
        fwrite(data, 1, n, f);
        fclose(f);
        expect_unreadable("test_cut.exr", ERR_FORMAT, "");
    }
    FILE *f = fopen("test_cut.exr", "wb");
    fputs("This is no picture.", f);
    fclose(f);
    expect_unreadable("test_cut.exr", ERR_FORMAT, "not an EXR");
    const image_exr_plane planes[] = {{"R", t->f[0]}, {"weight", t->f[1]}};
    assert_int_equal(image_exr_write_planes("test_cut.exr", &image, planes, 2), OK);
    expect_unreadable("test_cut.exr", ERR_FORMAT, "no channel Z");
    unlink("test_cut.exr");
    expect_unreadable("test_cut.exr", ERR_NOT_FOUND, "No such file");
    expect_unreadable(".", ERR_FORMAT, "");
}

static void test_contact_sheet(void **state)
{
    (void)state;
    enum { FW = 40, FH = 30, FRAMES = 21 };
    static uint8_t frame[3 * FW * FH];
    struct contact_sheet *sheet = contact_sheet_create(3, 2, 20, FW, FH, FRAMES);
    int w, h;
    contact_sheet_size(sheet, &w, &h);
    assert_int_equal(w, 3 * (20 + 4) + 4);
    assert_int_equal(h, 2 * (15 + 4) + 4);
    int wanted = 0;
    for (int i = 0; i < FRAMES; i++) {
        wanted += contact_sheet_wants(sheet, i);
        memset(frame, 10 * i, sizeof frame);
        contact_sheet_add(sheet, i, frame);
    }
    assert_int_equal(wanted, 6);
    const uint8_t *pixels = contact_sheet_pixels(sheet);
    for (int cell = 0; cell < 6; cell++) { // frames 0, 4, 8, 12, 16, 20
        int x = 4 + cell % 3 * 24, y = 4 + cell / 3 * 19;
        assert_int_equal(pixels[3 * (y * w + x)], 40 * cell);
        assert_int_equal(pixels[3 * ((y + 14) * w + x + 19) + 2], 40 * cell);
    }
    contact_sheet_destroy(&sheet);
    assert_null(sheet);
}

// Half black, half white pixels: half the light is sRGB 188, not 128.
static void test_contact_sheet_light(void **state)
{
    (void)state;
    uint8_t frame[3 * 8 * 8];
    for (int i = 0; i < 64; i++) memset(frame + 3 * i, (i + i / 8) % 2 ? 255 : 0, 3);
    struct contact_sheet *sheet = contact_sheet_create(1, 1, 4, 8, 8, 1);
    contact_sheet_add(sheet, 0, frame);
    int w, h;
    contact_sheet_size(sheet, &w, &h);
    assert_int_equal(contact_sheet_pixels(sheet)[3 * (5 * w + 5)], 188);
    contact_sheet_destroy(&sheet);
}

static void test_pattern(void **state)
{
    (void)state;
    static const char *const bad[] = {"a.png",     "%d%d.png",   "%s.png",   "%",      "%5.png",
                                      "%n.png",    "%d/a.png",   "%05d.mp4", "%d.jpg", "%*d.png",
                                      "%123d.png", "%05d-%.png", "%ld.png"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        lines = 0;
        if (frame_pattern_check(bad[i]) != ERR_ARGUMENT) fail_msg("'%s' was taken", bad[i]);
        assert_int_equal(lines, 1);
        assert_non_null(strstr(last, bad[i]));
    }
    static const struct {
        const char *pattern, *path;
    } good[] = {
        {"f/%05d.png", "f/00042.png"}, {"%d.PNG", "42.PNG"}, {"100%%-%3d.png", "100%-042.png"}};
    for (size_t i = 0; i < 3; i++) {
        char path[32];
        assert_int_equal(frame_pattern_check(good[i].pattern), OK);
        assert_int_equal(frame_pattern_path(good[i].pattern, 42, path, sizeof path), OK);
        assert_string_equal(path, good[i].path);
        assert_int_equal(frame_pattern_path(good[i].pattern, 42, path, 5), ERR_ARGUMENT);
    }
}

int main(void)
{
    log_set_sink(count_lines, NULL);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_png),
        cmocka_unit_test(test_png_bytes),
        cmocka_unit_test(test_unwritable),
        cmocka_unit_test(test_exr),
        cmocka_unit_test(test_exr_half),
        cmocka_unit_test(test_exr_read),
        cmocka_unit_test(test_exr_unreadable),
        cmocka_unit_test(test_contact_sheet),
        cmocka_unit_test(test_contact_sheet_light),
        cmocka_unit_test(test_pattern),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
