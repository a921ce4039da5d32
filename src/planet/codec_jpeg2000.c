#include "planet/codec_jpeg2000.h"

#include <openjpeg.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = TILE_SIZE * TILE_SIZE, BUFFER = 1 << 16 };

// A file in memory.
struct memory {
    const unsigned char *data;
    size_t size, at;
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

static opj_stream_t *open_stream(struct memory *m)
{
    opj_stream_t *s = opj_stream_create(BUFFER, OPJ_TRUE);
    if (!s) return NULL;
    opj_stream_set_user_data(s, m, NULL);
    opj_stream_set_user_data_length(s, m->size);
    opj_stream_set_read_function(s, read_memory);
    opj_stream_set_skip_function(s, skip_memory);
    opj_stream_set_seek_function(s, seek_memory);
    return s;
}

// Is it such a picture, before anything is made of its size?
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

status jpeg2000_decode(const void *data, size_t size, int32_t *values)
{
    struct memory m = {.data = data, .size = size};
    opj_codec_t *codec = opj_create_decompress(OPJ_CODEC_J2K);
    opj_stream_t *stream = open_stream(&m);
    opj_image_t *image = NULL;
    bool good = codec && stream && decompress(codec, stream, &image);
    if (good) memcpy(values, image->comps[0].data, SAMPLES * sizeof *values);
    opj_image_destroy(image);
    opj_stream_destroy(stream);
    opj_destroy_codec(codec);
    return good ? OK : !codec || !stream ? ERR_MEMORY : ERR_FORMAT;
}
