#include "planet/import_light.h"

#include <math.h>
#include <pthread.h>

// Steps of the encoding table: the smallest code interval, 1 / (255 * 12.92), holds 20 of them.
enum { ENCODE_STEPS = 65535 };

static float decode_table[257];
static unsigned char encode_table[ENCODE_STEPS + 1];
static pthread_once_t once = PTHREAD_ONCE_INIT;

// IEC 61966-2-1.
static double srgb_from_linear(double x)
{
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055;
}

static double linear_from_srgb(double x)
{
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

static void build_tables(void)
{
    for (int i = 0; i < 256; i++) decode_table[i] = (float)linear_from_srgb(i / 255.0);
    decode_table[256] = 1;
    for (int i = 0; i <= ENCODE_STEPS; i++)
        encode_table[i] = (unsigned char)lround(255 * srgb_from_linear((double)i / ENCODE_STEPS));
}

void light_decode(float *samples, size_t count)
{
    pthread_once(&once, build_tables);
    for (size_t i = 0; i < count; i++) {
        float v = samples[i];
        if (isnan(v)) continue;
        v = v < 0 ? 0 : v > 255 ? 255 : v;
        int code = (int)v;
        float t = v - (float)code;
        samples[i] = decode_table[code] + t * (decode_table[code + 1] - decode_table[code]);
    }
}

unsigned char light_encode(float linear)
{
    pthread_once(&once, build_tables);
    if (!(linear > 0)) return 0;
    return encode_table[linear >= 1 ? ENCODE_STEPS : (int)(linear * ENCODE_STEPS + 0.5f)];
}
