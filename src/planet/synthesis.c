#include "planet/synthesis.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "planet/upsample.h"

// rms of the raw noise over the sphere (tests/planet/test_synthesis.c); its lattice is two samples
// wide.
static const float NOISE_RMS = 0.2700f;

enum { GAIN_SAMPLES = 200 };

static inline uint32_t mix(uint32_t h)
{
    h ^= h >> 16;
    h *= 0x7feb352du;
    h ^= h >> 15;
    h *= 0x846ca68bu;
    return h ^ (h >> 16);
}

// Dot product of the offset with one of the twelve directions to the middles of a cube's edges
// (four stand twice).
static inline float corner(uint32_t h, float x, float y, float z)
{
    static const float directions[16][4] = {{1, 1, 0}, {-1, 1, 0}, {1, -1, 0}, {-1, -1, 0},
                                            {1, 0, 1}, {-1, 0, 1}, {1, 0, -1}, {-1, 0, -1},
                                            {0, 1, 1}, {0, -1, 1}, {0, 1, -1}, {0, -1, -1},
                                            {1, 1, 0}, {-1, 1, 0}, {0, -1, 1}, {0, -1, -1}};
    const float *d = directions[h >> 28];
    return d[0] * x + d[1] * y + d[2] * z;
}

// A lattice point's hash from its row's: one round is enough on top of a mixed row.
static inline uint32_t point(uint32_t row, uint32_t x)
{
    uint32_t h = (row ^ x) * 0x7feb352du;
    return (h ^ (h >> 15)) * 0x846ca68bu;
}

static inline float fade(float t)
{
    return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f);
}

static inline float lerp(float a, float b, float t)
{
    return a + (b - a) * t;
}

static inline int32_t floor_int(double x)
{
    int32_t i = (int32_t)x;
    return i - (x < i);
}

// One lattice plane's four corners, blended.
static inline float face(uint32_t hz, int32_t ix, int32_t iy, float x, float y, float z, float u,
                         float v)
{
    uint32_t h0 = mix(hz + (uint32_t)iy * 0x85ebca77u),
             h1 = mix(hz + (uint32_t)(iy + 1) * 0x85ebca77u);
    uint32_t x0 = (uint32_t)ix * 0x9e3779b1u, x1 = (uint32_t)(ix + 1) * 0x9e3779b1u;
    float a = lerp(corner(point(h0, x0), x, y, z), corner(point(h0, x1), x - 1, y, z), u);
    float b = lerp(corner(point(h1, x0), x, y - 1, z), corner(point(h1, x1), x - 1, y - 1, z), u);
    return lerp(a, b, v);
}

// |coordinates| below 2^31: the lattice of zoom 24 is 6.8e8 across.
static inline float lattice_noise(double px, double py, double pz, uint32_t seed)
{
    int32_t ix = floor_int(px), iy = floor_int(py), iz = floor_int(pz);
    float x = (float)(px - ix), y = (float)(py - iy), z = (float)(pz - iz);
    float u = fade(x), v = fade(y);
    uint32_t z0 = mix(seed + (uint32_t)iz * 0xc2b2ae3du),
             z1 = mix(seed + (uint32_t)(iz + 1) * 0xc2b2ae3du);
    return lerp(face(z0, ix, iy, x, y, z, u, v), face(z1, ix, iy, x, y, z - 1, u, v), fade(z));
}

// Lattice cells across the unit sphere's radius: two samples of the zoom wide.
static double lattice_scale(int zoom)
{
    return 1 / (2 * grid_step_lat(zoom));
}

float synthesis_noise(double x, double y, double z, int zoom)
{
    double s = lattice_scale(zoom);
    return lattice_noise(x * s, y * s, z * s, (uint32_t)zoom * 0x27d4eb2fu) / NOISE_RMS;
}

void synthesis_relief(const patch *p, double radius, float *relief)
{
    int n = p->cols;
    float cap = (float)(SYNTHESIS_MAX_SLOPE * radius * grid_step_lat(p->child.zoom - 1));
    for (int r = 1; r < PATCH_ROWS - 1; r++) {
        for (int c = 1; c < n - 1; c++) {
            const float *s = p->data + (size_t)r * (size_t)n + c;
            float low = s[0], high = s[0];
            for (int k = -1; k <= 1; k++) {
                const float *t = s + k * n;
                low = fminf(low, fminf(t[-1], fminf(t[0], t[1])));
                high = fmaxf(high, fmaxf(t[-1], fmaxf(t[0], t[1])));
            }
            float d = high - low;
            relief[(size_t)r * (size_t)n + c] = d / (1 + d / cap);
        }
    }
}

void synthesis_residual(const patch *p, double gain, double radius, const bool *flat,
                        float *residual)
{
    float relief[PATCH_ROWS * PATCH_MAX_COLS] = {0}, strength[TILE_SIZE];
    double cos_lon[TILE_SIZE], sin_lon[TILE_SIZE];
    tile_id id = p->child;
    double step = grid_step_lon(id.zoom, id.row), scale = lattice_scale(id.zoom);
    uint32_t seed = (uint32_t)id.zoom * 0x27d4eb2fu;
    for (int c = 0; c < TILE_SIZE; c++) {
        double lon = -M_PI + ((double)id.col * TILE_SIZE + c + 0.5) * step;
        cos_lon[c] = cos(lon) * scale;
        sin_lon[c] = sin(lon) * scale;
    }
    synthesis_relief(p, radius, relief);
    for (int r = 0; r < TILE_SIZE; r++) {
        double lat = grid_lat(id.zoom, (int64_t)id.row * TILE_SIZE + r);
        double cos_lat = cos(lat), z = sin(lat) * scale;
        float *out = residual + (size_t)r * TILE_SIZE;
        const bool *keep = flat + (size_t)r * TILE_SIZE;
        upsample_linear_row(p, relief, r, strength);
        for (int c = 0; c < TILE_SIZE; c++) {
            float amount = keep[c] ? 0 : strength[c] * (float)gain / NOISE_RMS;
            out[c] = amount == 0 ? 0
                                 : amount * lattice_noise(cos_lat * cos_lon[c],
                                                          cos_lat * sin_lon[c], z, seed);
        }
    }
}

struct sums {
    double residual, relief;
    int tiles;
};

static status fetch_stored(void *user, const patch_block *b)
{
    struct planet_writer *writer = user;
    codec_blob body;
    status s = planet_writer_get(writer, b->tile, &body);
    if (s) return s;
    float *tile = malloc(TILE_SIZE * TILE_SIZE * sizeof *tile);
    s = tile ? codec_height_decode(body.data, body.size, tile) : ERR_MEMORY;
    for (int r = 0; !s && r < b->rows; r++)
        memcpy(b->out + (size_t)r * (size_t)b->stride,
               tile + (size_t)(b->row + r) * TILE_SIZE + b->col, (size_t)b->cols * sizeof *tile);
    free(tile);
    codec_blob_deinit(&body);
    return s;
}

// Adds one tile's residual and relief; tiles without neighbours or with missing samples count
// nothing.
static status measure_tile(struct planet_writer *writer, tile_id id, double radius,
                           struct sums *sums)
{
    enum { SAMPLES = TILE_SIZE * TILE_SIZE };
    patch p = {0};
    codec_blob body;
    float *work = malloc((SAMPLES + PATCH_ROWS * PATCH_MAX_COLS) * sizeof *work);
    if (!work) return ERR_MEMORY;
    float *tile = work, *relief = work + SAMPLES, row[TILE_SIZE], strength[TILE_SIZE];
    status s = patch_init(&p, id, 1, fetch_stored, writer);
    if (!s) s = planet_writer_get(writer, id, &body);
    if (!s) {
        s = codec_height_decode(body.data, body.size, tile);
        codec_blob_deinit(&body);
    }
    struct sums t = {0};
    if (!s) synthesis_relief(&p, radius, relief);
    for (int r = 0; !s && r < TILE_SIZE; r++) {
        upsample_height_row(&p, r, row, NULL);
        upsample_linear_row(&p, relief, r, strength);
        for (int c = 0; c < TILE_SIZE; c++) {
            double d = tile[r * TILE_SIZE + c] - row[c];
            t.residual += d * d;
            t.relief += strength[c] * (double)strength[c];
        }
    }
    patch_deinit(&p);
    free(work);
    if (s == ERR_MEMORY) return s;
    if (!s && isfinite(t.residual) && isfinite(t.relief) && t.relief > 0) {
        sums->residual += t.residual;
        sums->relief += t.relief;
        sums->tiles++;
    }
    return OK;
}

status synthesis_measure_gain(struct planet_writer *writer, int max_zoom, double radius,
                              double *gain)
{
    struct sums sums = {0};
    *gain = 0.05;
    for (int zoom = max_zoom; zoom > 0 && zoom > max_zoom - 3; zoom--) {
        uint32_t state = 1;
        int tries = 0;
        for (int k = 0; k < GAIN_SAMPLES && tries < 20 * GAIN_SAMPLES; tries++) {
            state = mix(state + 0x9e3779b9u);
            int row = (int)(state % (uint32_t)grid_rows(zoom));
            state = mix(state + 0x9e3779b9u);
            tile_id id = {LAYER_HEIGHT, zoom, row, (int)(state % (uint32_t)grid_cols(zoom, row))};
            if (!planet_writer_has(writer, id)) continue;
            k += 3;
            status s = measure_tile(writer, id, radius, &sums);
            if (s) return s;
        }
    }
    if (sums.tiles) *gain = clamp_double(sqrt(sums.residual / sums.relief), 0.02, 0.08);
    return OK;
}
