// Writing a planet file. One writer a file, used by one thread at a time; encode on workers with
// codec.h.
#ifndef PERIGEE_PLANET_PLANET_WRITER_H
#define PERIGEE_PLANET_PLANET_WRITER_H

#include "planet/codec.h"
#include "planet/planet_file.h"

struct planet_writer;

// Creates the file, or with `resume` opens one begun before with the same fingerprint (a text that
// names sources and settings; ERR_ARGUMENT when it differs). ERR_IO when it cannot be written.
status planet_writer_open(const char *path, const char *fingerprint, bool resume,
                          struct planet_writer **out);

// Creates a file that is written in one go: quick, and useless unless finished. What it holds
// depends on the order of what is put and on nothing else, byte by byte.
status planet_writer_open_bulk(const char *path, const char *fingerprint,
                               struct planet_writer **out);

// ERR_IO, logged, when another writer is at the file, in this process or another: it must not be
// taken from under it. OK also where there is none. The opens above look by themselves.
status planet_writer_check_free(const char *path);

// Commits and closes. NULL-safe.
void planet_writer_close(struct planet_writer **writer);

// Is the tile committed or pending in this writer?
bool planet_writer_has(struct planet_writer *writer, tile_id id);

// Stores a body (copied; identical bodies share one row). min, max: heights of the tile and of its
// descendants (NaN ignored), 0 for pixels.
status planet_writer_put(struct planet_writer *writer, tile_id id, const codec_blob *body,
                         float min, float max);

// As planet_writer_put, of a body whose store_hash is known.
status planet_writer_put_hashed(struct planet_writer *writer, tile_id id, const codec_blob *body,
                                int64_t hash, float min, float max);

// Reads back a stored body and its range (committed or pending); ERR_NOT_FOUND silently,
// ERR_FORMAT, logged, when it is not what was put. Free with codec_blob_deinit.
status planet_writer_get(struct planet_writer *writer, tile_id id, codec_blob *body, float *min,
                         float *max);

// Makes the range of a tile that is there as wide as to hold [min, max].
status planet_writer_widen(struct planet_writer *writer, tile_id id, double min, double max);

// Finest zoom with a tile of the layer, committed or pending; -1 when there is none.
int planet_writer_max_zoom(struct planet_writer *writer, enum tile_layer layer);

// Up to `limit` tiles of one layer and zoom, evenly spread over all there are.
status planet_writer_sample(struct planet_writer *writer, enum tile_layer layer, int zoom,
                            int limit, tile_id *ids, int *count);

// Makes what was put durable; call every second or so.
status planet_writer_commit(struct planet_writer *writer);

// Commits and folds the log into the file, so that planet_part_open sees everything.
status planet_writer_seal(struct planet_writer *writer);

// keep: commits leave the file itself alone until the next seal, for others that read it.
status planet_writer_keep_log(struct planet_writer *writer, bool keep);

// Writes the metadata (max_zoom, height_min and height_max are computed from the tiles) with
// complete = true; commits.
status planet_writer_finish(struct planet_writer *writer, const struct planet_meta *meta);

#endif
