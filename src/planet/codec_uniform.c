#include "planet/codec_uniform.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = TILE_SIZE * TILE_SIZE, BODY = 8, HEAD = 4 };

static bool make_body(int channels, const unsigned char *value, size_t size, codec_blob *out)
{
    unsigned char *body = calloc(BODY, 1);
    if (!body) return false;
    memcpy(body, "PGU", 3);
    body[3] = (unsigned char)('0' + channels);
    memcpy(body + HEAD, value, size);
    *out = (codec_blob){body, BODY};
    return true;
}

static const unsigned char *value_of(const void *data, size_t size, int channels)
{
    const unsigned char *body = data;
    bool is = size == BODY && memcmp(body, "PGU", 3) == 0 && body[3] == '0' + channels;
    return is ? body + HEAD : NULL;
}

bool uniform_encode_height(const float *samples, codec_blob *out)
{
    // Bit by bit: -0 is not 0.
    if (!isfinite(samples[0]) || memcmp(samples, samples + 1, (SAMPLES - 1) * sizeof *samples) != 0)
        return false;
    uint32_t bits;
    memcpy(&bits, samples, sizeof bits);
    unsigned char value[4];
    for (int i = 0; i < 4; i++) value[i] = (unsigned char)(bits >> (8 * i));
    return make_body(0, value, sizeof value, out);
}

bool uniform_decode_height(const void *data, size_t size, float *samples)
{
    const unsigned char *value = value_of(data, size, 0);
    if (!value) return false;
    uint32_t bits = 0;
    for (int i = 0; i < 4; i++) bits |= (uint32_t)value[i] << (8 * i);
    float height;
    memcpy(&height, &bits, sizeof height);
    for (int i = 0; i < SAMPLES; i++) samples[i] = isfinite(height) ? height : NAN;
    return true;
}

bool uniform_encode_pixels(const unsigned char *pixels, int channels, codec_blob *out)
{
    size_t rest = (size_t)(SAMPLES - 1) * (size_t)channels;
    return memcmp(pixels, pixels + channels, rest) == 0 &&
           make_body(channels, pixels, (size_t)channels, out);
}

bool uniform_decode_pixels(const void *data, size_t size, int channels, unsigned char *pixels)
{
    const unsigned char *value = value_of(data, size, channels);
    if (!value) return false;
    for (int i = 0; i < SAMPLES; i++) memcpy(pixels + i * channels, value, (size_t)channels);
    return true;
}
