// Colour and night bodies: baseline JPEG images in memory, by TurboJPEG; tiles of one colour
// as in codec_uniform.h.
#include "planet/codec.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include <turbojpeg.h>

#include "planet/codec_uniform.h"

enum { MAX_BODY = 1 << 20 }; // over twice what a 256 x 256 baseline JPEG can need

status codec_pixels_encode_jpeg(const unsigned char *pixels, int channels, int quality,
                                codec_blob *out)
{
    assert((channels == 1 || channels == 3) && quality >= 1 && quality <= 100);
    *out = (codec_blob){0};
    tjhandle handle = tjInitCompress();
    if (!handle) return ERR_MEMORY;
    int format = channels == 1 ? TJPF_GRAY : TJPF_RGB;
    int subsampling = channels == 1 ? TJSAMP_GRAY : quality >= 90 ? TJSAMP_444 : TJSAMP_420;
    unsigned char *jpeg = NULL;
    unsigned long size = 0;
    status s = ERR_MEMORY;
    if (tjCompress2(handle, pixels, TILE_SIZE, 0, TILE_SIZE, format, &jpeg, &size, subsampling,
                    quality, TJFLAG_ACCURATEDCT) == 0) {
        out->data = malloc(size);
        if (out->data) {
            memcpy(out->data, jpeg, size);
            out->size = size;
            s = OK;
        }
    }
    tjFree(jpeg);
    tjDestroy(handle);
    return s;
}

status codec_pixels_encode(const unsigned char *pixels, int channels, int quality, codec_blob *out)
{
    if (uniform_encode_pixels(pixels, channels, out)) return OK;
    return codec_pixels_encode_jpeg(pixels, channels, quality, out);
}

status codec_pixels_decode(const void *data, size_t size, int channels, unsigned char *pixels)
{
    assert(channels == 1 || channels == 3);
    if (size == 0 || size > MAX_BODY) return ERR_FORMAT;
    if (uniform_decode_pixels(data, size, channels, pixels)) return OK;
    tjhandle handle = tjInitDecompress();
    if (!handle) return ERR_MEMORY;
    int width, height, subsampling, colorspace;
    int format = channels == 1 ? TJPF_GRAY : TJPF_RGB;
    status s = ERR_FORMAT;
    if (tjDecompressHeader3(handle, data, size, &width, &height, &subsampling, &colorspace) == 0 &&
        width == TILE_SIZE && height == TILE_SIZE && (colorspace == TJCS_GRAY) == (channels == 1) &&
        tjDecompress2(handle, data, size, pixels, TILE_SIZE, 0, TILE_SIZE, format,
                      TJFLAG_ACCURATEDCT | TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS) == 0)
        s = OK;
    tjDestroy(handle);
    return s;
}
