// How fast a global height raster becomes a planet file, beside the library steps that this takes
// in any case, each alone over the same tiles, on one thread:
//   bench_import RASTER FOLDER [QUANTUM [KEPT_MIB]]
// QUANTUM of heights, a power of two; 0: as floats (default 1, what the 2-minute relief has by
// itself). KEPT_MIB: bound of the tiles just made that are kept for the zoom above (default 512).
// One line of JSON: samples a second of the processor's time (and of the clock's). "encode" and
// "decode" are a body's whole making and reading; "coder" is the library's share of encoding alone
// (libaec), over the numbers that a body holds.
#include <gdal.h>
#include <libaec.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "planet/codec.h"
#include "planet/import.h"
#include "planet/planet_writer.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE };

struct timer {
    double cpu, clock;
};

static double at(clockid_t id)
{
    struct timespec t;
    clock_gettime(id, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double at_cpu(void)
{
    return at(CLOCK_PROCESS_CPUTIME_ID);
}

static struct timer begin(void)
{
    return (struct timer){at_cpu(), at(CLOCK_MONOTONIC)};
}

// Millions of samples a second of processor time.
static double rate(struct timer since, double samples)
{
    return 1e-6 * samples / (at_cpu() - since.cpu);
}

struct tiles {
    struct planet_file *file;
    tile_id *ids;
    size_t count, room;
};

static void add(void *user, tile_id id)
{
    struct tiles *t = user;
    if (t->count == t->room) {
        t->room = 2 * t->room + 1024;
        t->ids = realloc(t->ids, t->room * sizeof *t->ids);
        if (!t->ids) abort();
    }
    t->ids[t->count++] = id;
}

static double read_raster(const char *path)
{
    GDALDatasetH d = GDALOpen(path, GA_ReadOnly);
    if (!d) return 0;
    int width = GDALGetRasterXSize(d), height = GDALGetRasterYSize(d);
    float *row = malloc((size_t)width * sizeof *row);
    struct timer t = begin();
    for (int y = 0; row && y < height; y++)
        if (GDALRasterIO(GDALGetRasterBand(d, 1), GF_Read, 0, y, width, 1, row, width, 1,
                         GDT_Float32, 0, 0) != CE_None)
            break;
    double r = rate(t, (double)width * height);
    free(row);
    GDALClose(d);
    return r;
}

// Takes the numbers out of a body on the grid (planet/codec_grid.c says how it is laid out) and has
// the library code them again, as they were. *seconds grows by what that takes; of other bodies, by
// nothing.
static status code_again(const codec_blob *body, double *seconds)
{
    static unsigned char numbers[4 * SAMPLES], coded[5 * SAMPLES];
    if (body->size < 12 || memcmp(body->data, "PGL1", 4) != 0) return OK;
    size_t bits = body->data[5], bytes = bits <= 8 ? 1 : bits <= 16 ? 2 : 4, at = 12;
    for (int i = 0; i < 4; i++) at += (size_t)body->data[8 + i] << (8 * i);
    struct aec_stream s = {.bits_per_sample = (unsigned)bits, .block_size = 16, .rsi = 128};
    s.next_in = body->data + at;
    s.avail_in = body->size - at;
    s.next_out = numbers;
    s.avail_out = SAMPLES * bytes;
    if (aec_buffer_decode(&s) != AEC_OK) return ERR_FORMAT;
    s.next_in = numbers;
    s.avail_in = SAMPLES * bytes;
    s.next_out = coded;
    s.avail_out = sizeof coded;
    double began = at_cpu();
    if (aec_buffer_encode(&s) != AEC_OK) return ERR_FORMAT;
    *seconds += at_cpu() - began;
    bool same = s.total_out == body->size - at && !memcmp(coded, body->data + at, s.total_out);
    return same ? OK : ERR_FORMAT;
}

// Encodes, decodes and stores every tile; the rates of the three and of the library that encodes.
static status library_steps(struct tiles *t, const char *scratch, double quantum, double out[4])
{
    int exponent = quantum > 0 ? ilogb(quantum) : 0;
    float *heights = malloc(SAMPLES * sizeof *heights), *again = malloc(SAMPLES * sizeof *again);
    double encode_s = 0, decode_s = 0, store_s = 0, coder_s = 0;
    struct planet_writer *w = NULL;
    status s = heights && again ? planet_writer_open(scratch, "bench", false, &w) : ERR_MEMORY;
    for (size_t i = 0; !s && i < t->count; i++) {
        codec_blob body;
        s = planet_file_read_height(t->file, t->ids[i], heights);
        if (s) break;
        double c0 = at_cpu();
        s = quantum > 0 ? codec_height_encode_grid(heights, exponent, &body)
                        : codec_height_encode(heights, &body);
        double c1 = at_cpu();
        if (!s) s = codec_height_decode(body.data, body.size, again);
        double c2 = at_cpu();
        if (!s) s = planet_writer_put(w, t->ids[i], &body, 0, 0);
        if (!s && i % 64 == 63) s = planet_writer_commit(w);
        double c3 = at_cpu();
        encode_s += c1 - c0;
        decode_s += c2 - c1;
        store_s += c3 - c2;
        if (!s) s = code_again(&body, &coder_s);
        if (!s && memcmp(heights, again, SAMPLES * sizeof *heights)) s = ERR_FORMAT;
        codec_blob_deinit(&body);
    }
    planet_writer_close(&w);
    free(heights);
    free(again);
    double samples = (double)t->count * SAMPLES;
    out[0] = 1e-6 * samples / encode_s;
    out[1] = 1e-6 * samples / decode_s;
    out[2] = 1e-6 * samples / store_s;
    out[3] = coder_s > 0 ? 1e-6 * samples / coder_s : 0;
    return s;
}

int main(int argc, char **argv)
{
    if (argc < 3 || argc > 5) {
        fprintf(stderr, "usage: bench_import RASTER FOLDER [QUANTUM [KEPT_MIB]]\n");
        return 2;
    }
    char output[4096], scratch[4096];
    snprintf(output, sizeof output, "%s/bench-import.planet", argv[2]);
    snprintf(scratch, sizeof scratch, "%s/bench-import.scratch", argv[2]);
    import_source source = {.layer = LAYER_HEIGHT, .path = argv[1]};
    import_report r = {0};
    import_params p = {.sources = &source,
                       .source_count = 1,
                       .output = output,
                       .threads = 1,
                       .quantum = argc > 3 ? atof(argv[3]) : 1,
                       .kept_bytes = argc > 4 ? (size_t)atol(argv[4]) << 20 : 0,
                       .force = true,
                       .report = &r};
    GDALAllRegister();
    struct timer t = begin();
    status s = import_run(&p);
    double import_rate = rate(t, (double)r.samples), clock_s = at(CLOCK_MONOTONIC) - t.clock;
    struct tiles tiles = {0};
    double step[4] = {0};
    if (!s) s = planet_file_open(output, &tiles.file);
    if (!s) s = planet_file_list(tiles.file, LAYER_HEIGHT, add, &tiles);
    if (!s && tiles.count != r.tiles) s = ERR_FORMAT;
    if (!s) s = library_steps(&tiles, scratch, p.quantum, step);
    double read_rate = read_raster(argv[1]);
    if (!s)
        printf("{\"quantum\": %g, \"tiles\": %llu, \"samples\": %llu, \"bytes\": %llu, "
               "\"clock_s\": %.2f, "
               "\"import\": %.2f, \"read\": %.1f, \"encode\": %.2f, \"decode\": %.1f, "
               "\"store\": %.1f, \"coder\": %.1f, \"unit\": \"M samples a second of one core\"}\n",
               p.quantum, (unsigned long long)r.tiles, (unsigned long long)r.samples,
               (unsigned long long)r.bytes, clock_s, import_rate, read_rate, step[0], step[1],
               step[2], step[3]);
    planet_file_close(&tiles.file);
    free(tiles.ids);
    unlink(output);
    unlink(scratch);
    return s ? 1 : 0;
}
