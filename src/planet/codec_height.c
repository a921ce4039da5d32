// Height bodies: what kind one is, and OpenEXR images in memory: one part of scan lines, one float
// channel "Z", ZIP.
#include "planet/codec.h"

#include <math.h>
#include <openexr.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/vector.h"
#include "planet/codec_bounded.h"
#include "planet/codec_grid.h"
#include "planet/codec_predict.h"
#include "planet/codec_uniform.h"

enum {
    SAMPLES = TILE_SIZE * TILE_SIZE,
    // 256 KiB of samples that do not compress, plus header, chunk table and chunk heads.
    MAX_BODY = SAMPLES * 4 + 65536,
    ZIP_LEVEL = 6
};

void codec_blob_deinit(codec_blob *blob)
{
    free(blob->data);
    *blob = (codec_blob){0};
}

// A growing memory file for the writer, a fixed one for the reader.
struct memory_file {
    unsigned char *data;
    size_t size, capacity;
};

static void ignore_message(exr_const_context_t ctxt, exr_result_t code, const char *message)
{
    (void)ctxt;
    (void)code;
    (void)message;
}

static int64_t read_memory(exr_const_context_t ctxt, void *user, void *buffer, uint64_t size,
                           uint64_t offset, exr_stream_error_func_ptr_t error)
{
    (void)ctxt;
    (void)error;
    const struct memory_file *file = user;
    if (offset >= file->size) return 0;
    uint64_t left = file->size - offset;
    uint64_t n = size < left ? size : left;
    memcpy(buffer, file->data + offset, n);
    return (int64_t)n;
}

static int64_t memory_size(exr_const_context_t ctxt, void *user)
{
    (void)ctxt;
    return (int64_t)((const struct memory_file *)user)->size;
}

static int64_t write_memory(exr_const_context_t ctxt, void *user, const void *buffer, uint64_t size,
                            uint64_t offset, exr_stream_error_func_ptr_t error)
{
    (void)ctxt;
    (void)error;
    struct memory_file *file = user;
    if (offset > MAX_BODY || size > MAX_BODY - offset) return -1;
    size_t end = (size_t)(offset + size);
    if (end > file->capacity) {
        size_t capacity = end > 65536 ? 2 * end : 131072;
        unsigned char *data = realloc(file->data, capacity);
        if (!data) return -1;
        file->data = data;
        file->capacity = capacity;
    }
    if (offset > file->size) memset(file->data + file->size, 0, offset - file->size);
    memcpy(file->data + offset, buffer, size);
    if (end > file->size) file->size = end;
    return (int64_t)size;
}

static exr_context_initializer_t initializer(struct memory_file *file)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = ignore_message;
    init.user_data = file;
    init.read_fn = read_memory;
    init.size_fn = memory_size;
    init.write_fn = write_memory;
    init.max_image_width = init.max_image_height = TILE_SIZE;
    init.max_tile_width = init.max_tile_height = TILE_SIZE;
    init.zip_level = ZIP_LEVEL;
    return init;
}

static exr_result_t write_header(exr_context_t ctxt)
{
    exr_attr_box2i_t window;
    window.min.x = window.min.y = 0;
    window.max.x = window.max.y = TILE_SIZE - 1;
    exr_attr_v2f_t centre;
    centre.x = centre.y = 0.0f;
    int part;
    exr_result_t r = exr_add_part(ctxt, "height", EXR_STORAGE_SCANLINE, &part);
    if (!r)
        r = exr_initialize_required_attr(ctxt, part, &window, &window, 1.0f, &centre, 1.0f,
                                         EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_ZIP);
    if (!r) r = exr_add_channel(ctxt, part, "Z", EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LINEAR, 1, 1);
    return r ? r : exr_write_header(ctxt);
}

// OpenEXRCore takes a chunk whose size is that of its samples for one stored as it is, but its
// encoder keeps a compressed one of just that size (3.1.5; rough heights meet it about once in a
// hundred chunks). Such a chunk is stored as it is.
static exr_result_t compress_smaller(exr_encode_pipeline_t *pipe)
{
    exr_result_t (*compress)(exr_encode_pipeline_t *) = pipe->encoding_user_data;
    exr_result_t r = compress(pipe);
    if (!r && pipe->compressed_bytes == pipe->packed_bytes)
        memcpy(pipe->compressed_buffer, pipe->packed_buffer, pipe->packed_bytes);
    return r;
}

static exr_result_t write_chunks(exr_context_t ctxt, const float *samples)
{
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t lines = 0;
    exr_result_t r = exr_get_scanlines_per_chunk(ctxt, 0, &lines);
    for (int y = 0; !r && y < TILE_SIZE; y += lines) {
        exr_chunk_info_t chunk;
        r = exr_write_scanline_chunk_info(ctxt, 0, y, &chunk);
        if (!r)
            r = y == 0 ? exr_encoding_initialize(ctxt, 0, &chunk, &pipe)
                       : exr_encoding_update(ctxt, 0, &chunk, &pipe);
        if (r) break;
        pipe.channels[0].user_pixel_stride = sizeof(float);
        pipe.channels[0].user_line_stride = TILE_SIZE * sizeof(float);
        pipe.channels[0].encode_from_ptr = (const uint8_t *)(samples + (size_t)y * TILE_SIZE);
        if (y == 0) {
            r = exr_encoding_choose_default_routines(ctxt, 0, &pipe);
            pipe.encoding_user_data = (void *)pipe.compress_fn;
            pipe.compress_fn = compress_smaller;
        }
        if (!r) r = exr_encoding_run(ctxt, 0, &pipe);
    }
    exr_encoding_destroy(ctxt, &pipe);
    return r;
}

// Copies the samples with infinities made NaN. NULL when memory is out.
static float *finite_copy(const float *samples)
{
    float *copy = malloc(SAMPLES * sizeof *copy);
    if (!copy) return NULL;
    for (int i = 0; i < SAMPLES; i++) copy[i] = isfinite(samples[i]) ? samples[i] : NAN;
    return copy;
}

status codec_height_encode(const float *samples, codec_blob *out)
{
    *out = (codec_blob){0};
    if (uniform_encode_height(samples, out)) return OK;
    float *copy = finite_copy(samples);
    if (!copy) return ERR_MEMORY;
    struct memory_file file = {0};
    exr_context_initializer_t init = initializer(&file);
    exr_context_t ctxt = NULL;
    exr_result_t r = exr_start_write(&ctxt, "tile", EXR_WRITE_FILE_DIRECTLY, &init);
    if (!r) r = write_header(ctxt);
    if (!r) r = write_chunks(ctxt, copy);
    if (ctxt) {
        exr_result_t finished = exr_finish(&ctxt);
        if (!r) r = finished;
    }
    free(copy);
    if (r) {
        free(file.data);
        return ERR_MEMORY; // of a fixed-size image in memory, nothing else can fail
    }
    *out = (codec_blob){file.data, file.size};
    return OK;
}

VECTOR_CLONES static void take_rounded(const int32_t *counts, float quantum, float *samples)
{
    for (int i = 0; i < SAMPLES; i++)
        samples[i] = isfinite(samples[i]) ? (float)counts[i] * quantum : NAN;
}

status codec_height_encode_grid(float *samples, int exponent, codec_blob *out)
{
    *out = (codec_blob){0};
    int32_t *counts = malloc(SAMPLES * sizeof *counts);
    if (!counts) return ERR_MEMORY;
    bool holes;
    status s = OK;
    if (!grid_round(samples, exponent, counts, &holes)) {
        s = codec_height_encode(samples, out);
    } else {
        take_rounded(counts, ldexpf(1, exponent), samples);
        if (!uniform_encode_height(samples, out))
            s = grid_encode(counts, exponent, holes ? samples : NULL, out);
    }
    free(counts);
    return s;
}

// Is the open image what codec_height_encode makes?
static bool is_height_image(exr_context_t ctxt)
{
    int parts = 0;
    exr_storage_t storage;
    exr_compression_t compression;
    exr_attr_box2i_t window;
    const exr_attr_chlist_t *channels = NULL;
    if (exr_get_count(ctxt, &parts) || parts != 1) return false;
    if (exr_get_storage(ctxt, 0, &storage) || storage != EXR_STORAGE_SCANLINE) return false;
    if (exr_get_compression(ctxt, 0, &compression) || compression != EXR_COMPRESSION_ZIP)
        return false;
    if (exr_get_data_window(ctxt, 0, &window) || window.min.x != 0 || window.min.y != 0 ||
        window.max.x != TILE_SIZE - 1 || window.max.y != TILE_SIZE - 1)
        return false;
    if (exr_get_channels(ctxt, 0, &channels) || !channels || channels->num_channels != 1)
        return false;
    const exr_attr_chlist_entry_t *z = channels->entries;
    return z->pixel_type == EXR_PIXEL_FLOAT && z->x_sampling == 1 && z->y_sampling == 1 &&
           strcmp(z->name.str, "Z") == 0;
}

static exr_result_t read_chunks(exr_context_t ctxt, float *samples)
{
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    int32_t lines = 0;
    exr_result_t r = exr_get_scanlines_per_chunk(ctxt, 0, &lines);
    if (!r && (lines < 1 || TILE_SIZE % lines)) r = EXR_ERR_FILE_BAD_HEADER;
    for (int y = 0; !r && y < TILE_SIZE; y += lines) {
        exr_chunk_info_t chunk;
        r = exr_read_scanline_chunk_info(ctxt, 0, y, &chunk);
        if (r) break;
        if (chunk.start_x != 0 || chunk.start_y != y || chunk.width != TILE_SIZE ||
            chunk.height != lines ||
            chunk.unpacked_size != (uint64_t)lines * TILE_SIZE * sizeof(float)) {
            r = EXR_ERR_BAD_CHUNK_LEADER;
            break;
        }
        r = y == 0 ? exr_decoding_initialize(ctxt, 0, &chunk, &pipe)
                   : exr_decoding_update(ctxt, 0, &chunk, &pipe);
        if (r) break;
        pipe.channels[0].user_pixel_stride = sizeof(float);
        pipe.channels[0].user_line_stride = TILE_SIZE * sizeof(float);
        pipe.channels[0].decode_to_ptr = (uint8_t *)(samples + (size_t)y * TILE_SIZE);
        if (y == 0) r = exr_decoding_choose_default_routines(ctxt, 0, &pipe);
        if (!r) r = exr_decoding_run(ctxt, 0, &pipe);
    }
    exr_decoding_destroy(ctxt, &pipe);
    return r;
}

status codec_height_decode(const void *data, size_t size, float *samples)
{
    if (size == 0 || size > MAX_BODY) return ERR_FORMAT;
    if (uniform_decode_height(data, size, samples)) return OK;
    if (grid_is_body(data, size)) return grid_decode(data, size, samples);
    struct memory_file file = {(unsigned char *)data, size, size};
    exr_context_initializer_t init = initializer(&file);
    init.flags = EXR_CONTEXT_FLAG_STRICT_HEADER | EXR_CONTEXT_FLAG_SILENT_HEADER_PARSE |
                 EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    exr_context_t ctxt = NULL;
    exr_result_t r = exr_start_read(&ctxt, "tile", &init);
    if (!r && !is_height_image(ctxt)) r = EXR_ERR_FILE_BAD_HEADER;
    if (!r) r = read_chunks(ctxt, samples);
    if (ctxt) exr_finish(&ctxt);
    if (r) return r == EXR_ERR_OUT_OF_MEMORY ? ERR_MEMORY : ERR_FORMAT;
    for (int i = 0; i < SAMPLES; i++)
        if (!isfinite(samples[i])) samples[i] = NAN;
    return OK;
}

status codec_height_gaps(const void *data, size_t size, unsigned char *mask)
{
    if (size > 0 && size <= MAX_BODY && grid_is_body(data, size))
        return grid_holes(data, size, mask);
    float *samples = malloc(SAMPLES * sizeof *samples);
    if (!samples) return ERR_MEMORY;
    status s = codec_height_decode(data, size, samples);
    memset(mask, 0, SAMPLES / 8);
    for (int i = 0; !s && i < SAMPLES; i++)
        if (isnan(samples[i])) mask[i / 8] |= (unsigned char)(1u << (i % 8));
    free(samples);
    return s;
}

status codec_height_decode_tile(tile_id id, const void *data, size_t size, codec_parent parent,
                                void *user, float *samples)
{
    if (!bounded_is_body(data, size)) return codec_height_decode(data, size, samples);
    float *above = malloc(2 * SAMPLES * sizeof *above);
    if (!above) return ERR_MEMORY;
    status s = id.zoom > 0 ? parent(user, tile_parent(id), above) : ERR_NOT_FOUND;
    if (s == OK || s == ERR_NOT_FOUND) {
        predict_tile(id, s ? NULL : above, above + SAMPLES);
        s = bounded_decode(data, size, above + SAMPLES, samples);
    }
    free(above);
    return s;
}
