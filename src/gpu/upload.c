// Coherent persistent mapping: what is copied into the share before a command is seen by that
// command, and the fence at the share's end says when it may be written again.
#include "gpu/upload.h"

#include <assert.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "gpu/context.h"
#include "gpu/pixel_store.h"

enum { SHARES = 3, SHARE_ALIGN = 256, TEXEL_ALIGN = 16 };

struct gpu_upload {
    GLuint buffer;
    unsigned char *mapped;
    GLsync fences[SHARES];
    size_t share_bytes;
    size_t used; // of the current share; a multiple of TEXEL_ALIGN
    size_t total;
    int share;
    bool open;
    struct pixel_store saved; // while open
};

static size_t round_up(size_t n, size_t step)
{
    return (n + step - 1) / step * step;
}

static status map_buffer(struct gpu_upload *u)
{
    const GLbitfield access = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    GLsizeiptr bytes = (GLsizeiptr)(SHARES * u->share_bytes);
    gpu_context_forgive();
    glCreateBuffers(1, &u->buffer);
    glNamedBufferStorage(u->buffer, bytes, NULL, access);
    GLenum error = glGetError();
    if (!error) u->mapped = glMapNamedBufferRange(u->buffer, 0, bytes, access);
    if (u->mapped) return OK;
    log_error("no upload buffer of %zu bytes: OpenGL error 0x%04x", (size_t)bytes,
              error ? error : glGetError());
    return ERR_GPU;
}

status gpu_upload_create(size_t bytes_per_frame, struct gpu_upload **out)
{
    *out = NULL;
    if (bytes_per_frame == 0 || bytes_per_frame > PTRDIFF_MAX / SHARES - SHARE_ALIGN) {
        log_error("an upload share of %zu bytes a frame is impossible", bytes_per_frame);
        return ERR_ARGUMENT;
    }
    struct gpu_upload *u = NEW(struct gpu_upload);
    u->share_bytes = round_up(bytes_per_frame, SHARE_ALIGN);
    status s = map_buffer(u);
    if (s) gpu_upload_destroy(&u);
    *out = u;
    return s;
}

void gpu_upload_destroy(struct gpu_upload **upload)
{
    struct gpu_upload *u = *upload;
    if (!u) return;
    for (int i = 0; i < SHARES; i++) glDeleteSync(u->fences[i]);
    if (u->mapped) glUnmapNamedBuffer(u->buffer);
    glDeleteBuffers(1, &u->buffer);
    free(u);
    *upload = NULL;
}

bool gpu_upload_begin(struct gpu_upload *u)
{
    assert(!u->open);
    GLsync fence = u->fences[u->share];
    if (fence) {
        GLenum state = glClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, 0);
        if (state != GL_ALREADY_SIGNALED && state != GL_CONDITION_SATISFIED) return false;
        glDeleteSync(fence);
        u->fences[u->share] = NULL;
    }
    pixel_store_tight(&u->saved, PIXEL_UNPACK, u->buffer);
    u->used = 0;
    u->open = true;
    return true;
}

size_t gpu_upload_room(const struct gpu_upload *u)
{
    return u->open ? u->share_bytes - u->used : 0;
}

void gpu_upload_texture(struct gpu_upload *u, GLuint texture, int layer, int x, int y, int width,
                        int height, GLenum format, GLenum type, const void *texels, size_t bytes)
{
    assert(u->open && bytes <= gpu_upload_room(u));
    size_t offset = (size_t)u->share * u->share_bytes + u->used;
    memcpy(u->mapped + offset, texels, bytes);
    glTextureSubImage3D(texture, 0, x, y, layer, width, height, 1, format, type,
                        (const void *)(uintptr_t)offset);
    u->used += round_up(bytes, TEXEL_ALIGN);
    u->total += bytes;
}

void gpu_upload_end(struct gpu_upload *u)
{
    assert(u->open);
    if (u->used) {
        u->fences[u->share] = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
        u->share = (u->share + 1) % SHARES;
    }
    pixel_store_restore(&u->saved);
    u->open = false;
}

size_t gpu_upload_total(const struct gpu_upload *u)
{
    return u->total;
}
