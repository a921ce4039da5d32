#include "planet/codec_wavelet.h"

#include <math.h>
#include <openjpeg.h>
#include <stdlib.h>
#include <string.h>

enum {
    SAMPLES = TILE_SIZE * TILE_SIZE,
    RESOLUTIONS = 6,
    BUFFER = 1 << 16,
    // Over what SAMPLES of 24 bits take.
    MAX_PICTURE = SAMPLES * 4
};

// A growing memory file for the writer, a fixed one for the reader.
struct memory {
    unsigned char *data;
    size_t size, at, room;
};

static OPJ_SIZE_T read_memory(void *to, OPJ_SIZE_T size, void *user)
{
    struct memory *m = user;
    size_t left = m->size - m->at;
    if (left == 0) return (OPJ_SIZE_T)-1;
    if (size > left) size = left;
    memcpy(to, m->data + m->at, size);
    m->at += size;
    return size;
}

static OPJ_SIZE_T write_memory(void *from, OPJ_SIZE_T size, void *user)
{
    struct memory *m = user;
    if (size > MAX_PICTURE - m->at) return (OPJ_SIZE_T)-1;
    if (m->at + size > m->room) {
        size_t room = 2 * (m->at + size);
        unsigned char *data = realloc(m->data, room);
        if (!data) return (OPJ_SIZE_T)-1;
        m->data = data;
        m->room = room;
    }
    memcpy(m->data + m->at, from, size);
    m->at += size;
    if (m->at > m->size) m->size = m->at;
    return size;
}

static OPJ_OFF_T skip_memory(OPJ_OFF_T count, void *user)
{
    struct memory *m = user;
    if (count < 0 || (size_t)count > m->size - m->at) return -1;
    m->at += (size_t)count;
    return count;
}

static OPJ_BOOL seek_memory(OPJ_OFF_T at, void *user)
{
    struct memory *m = user;
    if (at < 0 || (size_t)at > m->size) return OPJ_FALSE;
    m->at = (size_t)at;
    return OPJ_TRUE;
}

static opj_stream_t *open_stream(struct memory *m, bool reads)
{
    opj_stream_t *s = opj_stream_create(BUFFER, reads);
    if (!s) return NULL;
    opj_stream_set_user_data(s, m, NULL);
    opj_stream_set_user_data_length(s, m->size);
    opj_stream_set_read_function(s, read_memory);
    opj_stream_set_write_function(s, write_memory);
    opj_stream_set_skip_function(s, skip_memory);
    opj_stream_set_seek_function(s, seek_memory);
    return s;
}

// Bits of a signed number that holds all of the values.
static int bits_of(const int32_t *values)
{
    int32_t most = 0;
    for (int i = 0; i < SAMPLES; i++) {
        int32_t v = values[i] < 0 ? -values[i] : values[i];
        most = v > most ? v : most;
    }
    int bits = 1;
    while (most >> (bits - 1)) bits++;
    return bits;
}

static opj_image_t *make_image(const int32_t *values, int bits)
{
    opj_image_cmptparm_t p = {
        .dx = 1, .dy = 1, .w = TILE_SIZE, .h = TILE_SIZE, .prec = (OPJ_UINT32)bits, .sgnd = 1};
    opj_image_t *image = opj_image_create(1, &p, OPJ_CLRSPC_GRAY);
    if (!image) return NULL;
    image->x1 = image->y1 = TILE_SIZE;
    memcpy(image->comps[0].data, values, SAMPLES * sizeof *values);
    return image;
}

static bool compress(opj_codec_t *codec, opj_image_t *image, opj_stream_t *stream, int bits,
                     double rms)
{
    opj_cparameters_t p;
    opj_set_default_encoder_parameters(&p);
    p.numresolution = RESOLUTIONS;
    p.irreversible = 0;
    p.tcp_numlayers = 1;
    p.cp_fixed_quality = 1;
    p.tcp_distoratio[0] = (float)(20 * log10((ldexp(1, bits) - 1) / rms));
    return opj_setup_encoder(codec, &p, image) && opj_start_compress(codec, image, stream) &&
           opj_encode(codec, stream) && opj_end_compress(codec, stream);
}

status wavelet_encode(const int32_t *values, double rms, codec_blob *out)
{
    *out = (codec_blob){0};
    for (int i = 0; i < SAMPLES; i++)
        if (values[i] <= -WAVELET_LIMIT || values[i] >= WAVELET_LIMIT) return ERR_UNSUPPORTED;
    struct memory m = {0};
    int bits = bits_of(values);
    opj_codec_t *codec = opj_create_compress(OPJ_CODEC_J2K);
    opj_image_t *image = make_image(values, bits);
    opj_stream_t *stream = open_stream(&m, false);
    bool good = codec && image && stream && compress(codec, image, stream, bits, rms);
    opj_stream_destroy(stream);
    opj_image_destroy(image);
    opj_destroy_codec(codec);
    if (!good) {
        free(m.data);
        return ERR_MEMORY; // of a fixed-size picture in memory, nothing else can fail
    }
    *out = (codec_blob){m.data, m.size};
    return OK;
}

// Is it what wavelet_encode makes, before anything is made of its size?
static bool is_picture(const opj_image_t *image)
{
    if (image->numcomps != 1 || image->x0 || image->y0 || image->x1 != TILE_SIZE ||
        image->y1 != TILE_SIZE)
        return false;
    const opj_image_comp_t *c = image->comps;
    return c->dx == 1 && c->dy == 1 && c->w == TILE_SIZE && c->h == TILE_SIZE && c->sgnd &&
           c->prec >= 1 && c->prec <= 24;
}

static bool decompress(opj_codec_t *codec, opj_stream_t *stream, opj_image_t **image)
{
    opj_dparameters_t p;
    opj_set_default_decoder_parameters(&p);
    if (!opj_setup_decoder(codec, &p) || !opj_decoder_set_strict_mode(codec, OPJ_TRUE) ||
        !opj_read_header(stream, codec, image) || !is_picture(*image))
        return false;
    return opj_decode(codec, stream, *image) && opj_end_decompress(codec, stream) &&
           (*image)->comps[0].data;
}

status wavelet_decode(const void *data, size_t size, int32_t *values)
{
    struct memory m = {.data = (unsigned char *)data, .size = size};
    opj_codec_t *codec = opj_create_decompress(OPJ_CODEC_J2K);
    opj_stream_t *stream = open_stream(&m, true);
    opj_image_t *image = NULL;
    bool good = codec && stream && decompress(codec, stream, &image);
    if (good) memcpy(values, image->comps[0].data, SAMPLES * sizeof *values);
    opj_image_destroy(image);
    opj_stream_destroy(stream);
    opj_destroy_codec(codec);
    return good ? OK : !codec || !stream ? ERR_MEMORY : ERR_FORMAT;
}
