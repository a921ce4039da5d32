// The form of Asirvatham & Hoppe 2005: blocks and the other footprints (planar_pieces.h), culled
// one by one, drawn as instances.
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "gpu/context.h"
#include "render/planar_parts.h"
#include "render/planar_pieces.h"

struct instance {
    uint32_t row, column, level, number;
};

// Instances of one footprint in a group, in the order in which they are drawn.
struct batch {
    int first, count;
};

enum { MAX_INSTANCES = CLIPMAP_MAX_LEVELS * (PLANAR_BLOCKS + PLANAR_PIECES) };

struct planar_footprints {
    int n;
    planar_footprint piece[PLANAR_PIECES];
    GLuint vertex_array, vertices, indices, instances;
    struct instance instance[MAX_INSTANCES];
    struct batch batch[CLIPMAP_MAX_LEVELS][PLANAR_PIECES]; // by group
    int count;
};

static GLuint make_buffer(struct planar *p, size_t bytes, const void *data)
{
    GLuint buffer;
    glCreateBuffers(1, &buffer);
    glNamedBufferStorage(buffer, (GLsizeiptr)bytes, data, data ? 0 : GL_DYNAMIC_STORAGE_BIT);
    p->gpu_bytes += bytes;
    return buffer;
}

status planar_footprints_create(struct planar *p, struct planar_footprints **out)
{
    struct planar_footprints *o = NEW(struct planar_footprints);
    gpu_context_forgive();
    o->n = p->n;
    planar_pieces pieces = planar_pieces_make(p->n);
    memcpy(o->piece, pieces.piece, sizeof o->piece);
    o->vertices = make_buffer(p, pieces.vertex_count * 2 * sizeof(uint16_t), pieces.vertices);
    o->indices = make_buffer(p, pieces.index_count * sizeof(uint16_t), pieces.indices);
    o->instances = make_buffer(p, sizeof o->instance, NULL);
    planar_pieces_free(&pieces);
    o->vertex_array = planar_vertex_array(o->vertices, o->instances, o->indices);
    *out = o;
    if (glGetError() == GL_NO_ERROR) return OK;
    log_error("the GPU refused the footprints of squares of %d vertices", p->n);
    return ERR_GPU;
}

void planar_footprints_destroy(struct planar_footprints **footprints)
{
    struct planar_footprints *o = *footprints;
    if (!o) return;
    const GLuint buffers[] = {o->vertices, o->indices, o->instances};
    glDeleteBuffers(3, buffers);
    glDeleteVertexArrays(1, &o->vertex_array);
    free(o);
    *footprints = NULL;
}

// In an instance's level, above PLANAR_IS_BORDER: the footprint.
enum { PIECE_SHIFT = 16 };

static void add_instance(struct planar_footprints *o, int level, int piece, const int offset[2])
{
    int border = piece == PLANAR_BORDER ? PLANAR_IS_BORDER : 0;
    struct instance *i = &o->instance[o->count];
    *i = (struct instance){(uint32_t)offset[0], (uint32_t)offset[1],
                           (uint32_t)(level | border | piece << PIECE_SHIFT), (uint32_t)o->count};
    o->count++;
}

// Near to far, so that what is hidden is not shaded.
static void select_blocks(struct planar_footprints *o, const struct planar *p,
                          const geometry_frame *f, int first, int last)
{
    int side = (p->n + 1) / 4 - 1;
    for (int level = last; level >= first; level--) {
        int blocks = level == p->last ? PLANAR_BLOCKS : PLANAR_RING_BLOCKS;
        for (int k = blocks - 1; k >= 0; k--) {
            int offset[2];
            planar_block_offset(p->n, k, offset);
            planar_region block = {offset[0], offset[0] + side, offset[1], offset[1] + side};
            if (planar_visible(p, f, level, block)) add_instance(o, level, PLANAR_BLOCK, offset);
        }
    }
}

static enum planar_piece trim_of(const struct planar *p, int level)
{
    const nest_square *s = &p->square[level];
    nest_square finer = p->square[level + 1];
    int m = (p->n + 1) / 4;
    // The finer level leaves the row free on the side from which it keeps off.
    int row_last = finer.row / 2 - s->row == m - 1;
    int column_last = finer.column / 2 - s->column == m - 1;
    return (enum planar_piece)(PLANAR_TRIM + 2 * row_last + column_last);
}

static bool has_piece(const struct planar *p, int piece, int level)
{
    switch (piece) {
    case PLANAR_FIXUP:
        return true;
    case PLANAR_CROSS:
        return level == p->last;
    case PLANAR_BORDER:
        return level > p->first;
    case PLANAR_CLOSING:
        return level == 0 && !p->plane;
    default:
        return level < p->last && (int)trim_of(p, level) == piece;
    }
}

static void select_group(struct planar_footprints *o, const struct planar *p,
                         const geometry_frame *f, int group)
{
    const int whole[2] = {0, 0};
    bool seen[CLIPMAP_MAX_LEVELS];
    int first = group ? p->together + group : p->first, last = p->together + group;
    struct batch *batch = o->batch[group];
    for (int level = first; level <= last; level++)
        seen[level] = planar_visible(p, f, level, p->active[level]);
    for (int piece = 0; piece < PLANAR_PIECES; piece++) {
        batch[piece].first = o->count;
        if (piece == PLANAR_BLOCK) select_blocks(o, p, f, first, last);
        for (int level = last; level >= first && piece != PLANAR_BLOCK; level--)
            if (seen[level] && has_piece(p, piece, level)) add_instance(o, level, piece, whole);
        batch[piece].count = o->count - batch[piece].first;
    }
}

void planar_footprints_select(struct planar_footprints *o, const struct planar *p,
                              const geometry_frame *f)
{
    o->count = 0;
    for (int group = 0; group <= p->last - p->together; group++) select_group(o, p, f, group);
    glNamedBufferSubData(o->instances, 0, (GLsizeiptr)((size_t)o->count * sizeof *o->instance),
                         o->instance);
}

static void draw_batch(const struct planar_footprints *o, int group, enum planar_piece i)
{
    const planar_footprint *piece = &o->piece[i];
    const struct batch *batch = &o->batch[group][i];
    if (batch->count)
        glDrawElementsInstancedBaseVertexBaseInstance(
            GL_TRIANGLES, (GLsizei)piece->indices, GL_UNSIGNED_SHORT,
            (const void *)(uintptr_t)(piece->first_index * sizeof(uint16_t)), batch->count,
            (GLint)piece->first_vertex, (GLuint)batch->first);
}

void planar_footprints_draw(const struct planar_footprints *o, int group, geometry_counts *counts)
{
    for (int i = 0; i < PLANAR_PIECES; i++) {
        int count = o->batch[group][i].count;
        counts->triangles_drawn += (uint64_t)count * o->piece[i].indices / 3;
        counts->draws += count > 0;
    }
    glBindVertexArray(o->vertex_array);
    for (int i = 0; i < PLANAR_PIECES; i++)
        if (i != PLANAR_BORDER) draw_batch(o, group, (enum planar_piece)i);
    // Drivers may tell the facing of a triangle by its corners and cover pixels by the corners
    // rounded: a sliver would be culled either way round.
    glDisable(GL_CULL_FACE);
    draw_batch(o, group, PLANAR_BORDER);
    glEnable(GL_CULL_FACE);
}

// The sector: a block's number, 16 and on for the other footprints.
void planar_footprints_identify(const struct planar_footprints *o, uint32_t number, int *level,
                                int *sector)
{
    const struct instance *i = &o->instance[number];
    int piece = (int)(i->level >> PIECE_SHIFT);
    *level = (int)(i->level & (PLANAR_IS_BORDER - 1));
    *sector = PLANAR_BLOCKS - 1 + piece;
    int offset[2];
    for (int k = 0; piece == PLANAR_BLOCK && k < PLANAR_BLOCKS; k++) {
        planar_block_offset(o->n, k, offset);
        if (i->row == (uint32_t)offset[0] && i->column == (uint32_t)offset[1]) *sector = k;
    }
}
