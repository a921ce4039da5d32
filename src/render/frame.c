#include "render/frame.h"

#include <stdio.h>
#include <string.h>

#include "gpu/context.h"
#include "gpu/program.h"

#define FULLSCREEN "shade/fullscreen.vert"

enum { SHADE_GROUP = 8, DEFINES_SIZE = 512 }; // pixels of a work group of shade.comp, each way

static status create_fragment_programs(frame *f, const char *defines)
{
    char sky[DEFINES_SIZE];
    snprintf(sky, sizeof sky, "%s#define SKY\n", defines ? defines : "");
    status s =
        gpu_program_create_render(FULLSCREEN, "shade/shade.frag", defines, &f->shade_program);
    if (!s) s = gpu_program_create_render(FULLSCREEN, "shade/shade.frag", sky, &f->sky_program);
    return s;
}

status frame_init(frame *f, const char *defines, bool texcoord_vertex, bool identify)
{
    memset(f, 0, sizeof *f);
    f->texcoord_vertex = texcoord_vertex;
    f->identify = identify;
    f->compute = gpu_prefers_compute();
    status s = f->compute
                   ? gpu_program_create_compute("shade/shade.comp", defines, &f->shade_program)
                   : create_fragment_programs(f, defines);
    if (!s)
        s = gpu_program_create_render(FULLSCREEN, "resolve/resolve.frag", defines,
                                      &f->resolve_program);
    if (s) return s;
    glCreateVertexArrays(1, &f->empty_array);
    glCreateBuffers(1, &f->view_buffer);
    glNamedBufferStorage(f->view_buffer, sizeof(struct view_block), NULL, GL_DYNAMIC_STORAGE_BIT);
    glCreateBuffers(1, &f->levels_buffer);
    glNamedBufferStorage(f->levels_buffer, sizeof(struct levels_block), NULL,
                         GL_DYNAMIC_STORAGE_BIT);
    return OK;
}

void frame_deinit(frame *f)
{
    gpu_target_deinit(&f->geometry);
    gpu_target_deinit(&f->light);
    if (f->shade_program) glDeleteProgram(f->shade_program);
    if (f->sky_program) glDeleteProgram(f->sky_program);
    if (f->resolve_program) glDeleteProgram(f->resolve_program);
    glDeleteVertexArrays(1, &f->empty_array);
    const GLuint buffers[2] = {f->view_buffer, f->levels_buffer};
    glDeleteBuffers(2, buffers);
    memset(f, 0, sizeof *f);
}

status frame_resize(frame *f, int width, int height)
{
    if (f->light.framebuffer && f->light.width == width && f->light.height == height) return OK;
    gpu_target_deinit(&f->geometry);
    gpu_target_deinit(&f->light);
    GLenum geometry[3] = {GL_RG32F}, light[1] = {GL_RGBA16F};
    int count = 1;
    if (f->texcoord_vertex) geometry[count++] = GL_RG32F;
    if (f->identify) geometry[count++] = GL_RG32UI;
    status s = gpu_target_init(&f->geometry, width, height, geometry, count, GL_DEPTH_COMPONENT32F);
    if (!s)
        s = gpu_target_init(&f->light, width, height, light, 1,
                            f->compute ? 0 : GL_DEPTH_COMPONENT32F);
    if (s) {
        gpu_target_deinit(&f->geometry);
        gpu_target_deinit(&f->light);
        return s;
    }
    glTextureParameteri(f->light.colors[0], GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(f->light.colors[0], GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(f->light.colors[0], GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(f->light.colors[0], GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    return OK;
}

size_t frame_target_bytes(const frame *f)
{
    size_t pixels = (size_t)f->light.width * (size_t)f->light.height;
    return pixels * (8u + 4u + (f->compute ? 0u : 4u) + (f->texcoord_vertex ? 16u : 8u) +
                     (f->identify ? 8u : 0u));
}

void frame_read_identifiers(const frame *f, uint32_t *pairs)
{
    gpu_target_read(&f->geometry, f->geometry.colors[f->texcoord_vertex ? 2 : 1], GL_RG_INTEGER,
                    GL_UNSIGNED_INT, 2 * sizeof *pairs, pairs);
}

void frame_set_blocks(frame *f, const struct view_block *view, const struct levels_block *levels)
{
    glNamedBufferSubData(f->view_buffer, 0, sizeof *view, view);
    glNamedBufferSubData(f->levels_buffer, 0, sizeof *levels, levels);
}

static void bind_blocks(frame *f)
{
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, f->view_buffer);
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, f->levels_buffer);
}

void frame_begin_geometry(frame *f, const struct windows *w)
{
    bind_blocks(f);
    glBindTextureUnit(0, windows_heights(w));
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, f->geometry.framebuffer);
    glViewport(0, 0, f->geometry.width, f->geometry.height);
    glDisable(GL_BLEND);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_STENCIL_TEST);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_GREATER);
    glEnable(GL_CULL_FACE);
    glCullFace(GL_BACK);
    glFrontFace(GL_CCW);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    const GLfloat none[4] = {0}, far_away = 0;
    const GLuint nothing[4] = {0};
    int floats = f->texcoord_vertex ? 2 : 1;
    for (int i = 0; i < floats; i++)
        glClearNamedFramebufferfv(f->geometry.framebuffer, GL_COLOR, i, none);
    if (f->identify) glClearNamedFramebufferuiv(f->geometry.framebuffer, GL_COLOR, floats, nothing);
    glClearNamedFramebufferfv(f->geometry.framebuffer, GL_DEPTH, 0, &far_away);
}

static void full_screen(frame *f, GLuint program)
{
    glDisable(GL_CULL_FACE);
    glUseProgram(program);
    glBindVertexArray(f->empty_array);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

static void shade_pixels(frame *f)
{
    if (!f->compute) {
        full_screen(f, f->shade_program);
        return;
    }
    glUseProgram(f->shade_program);
    glBindImageTexture(0, f->light.colors[0], 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA16F);
    glDispatchCompute((GLuint)(f->light.width + SHADE_GROUP - 1) / SHADE_GROUP,
                      (GLuint)(f->light.height + SHADE_GROUP - 1) / SHADE_GROUP, 1);
}

// While levels take turns with their layers, what needs a level is shaded when it is there.
static void shade_planet(frame *f, struct windows *w)
{
    int from = 0, last = windows_last_height(w);
    int to = windows_fleeting(w) && windows_kept(w) <= last ? windows_kept(w) - 1 : last;
    windows_begin_sweep(w);
    for (;;) {
        if (windows_fleeting(w)) glProgramUniform2i(f->shade_program, 0, from, to);
        shade_pixels(f);
        if (to == last) return;
        glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT); // the layers are written again
        from = to + 1;
        to = windows_make(w, from, true) ? from : last;
    }
}

static void shade_by_compute(frame *f, struct windows *w)
{
    shade_planet(f, w);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT |
                    GL_TEXTURE_UPDATE_BARRIER_BIT);
}

static void shade_by_fragments(frame *f, struct windows *w)
{
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, f->light.framebuffer);
    glViewport(0, 0, f->light.width, f->light.height);
    glBlitNamedFramebuffer(f->geometry.framebuffer, f->light.framebuffer, 0, 0, f->light.width,
                           f->light.height, 0, 0, f->light.width, f->light.height,
                           GL_DEPTH_BUFFER_BIT, GL_NEAREST);
    // The triangle lies at depth 0, which is infinity: it differs from the planet's depth and
    // equals the sky's.
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_NOTEQUAL);
    shade_planet(f, w);
    glDepthFunc(GL_EQUAL);
    full_screen(f, f->sky_program);
    glDepthMask(GL_TRUE);
}

void frame_shade(frame *f, struct windows *w)
{
    bind_blocks(f);
    glBindTextureUnit(0, windows_heights(w));
    glBindTextureUnit(1, windows_normals(w));
    glBindTextureUnit(2, windows_colors(w));
    glBindTextureUnit(3, f->geometry.colors[0]);
    glBindTextureUnit(4, f->geometry.depth);
    glBindTextureUnit(6, windows_convexity(w));
    if (f->texcoord_vertex) glBindTextureUnit(5, f->geometry.colors[1]);
    if (f->compute) shade_by_compute(f, w);
    else shade_by_fragments(f, w);
}

void frame_resolve(frame *f, GLuint framebuffer, bool antialias)
{
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, f->light.width, f->light.height);
    glDisable(GL_BLEND);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_STENCIL_TEST);
    glDisable(GL_FRAMEBUFFER_SRGB);
    glDisable(GL_DEPTH_TEST);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glBindTextureUnit(0, f->light.colors[0]);
    glBindTextureUnit(1, f->geometry.depth);
    glProgramUniform1i(f->resolve_program, 0, antialias);
    full_screen(f, f->resolve_program);
}

void frame_state_save(struct frame_state *s)
{
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &s->framebuffer);
    glGetIntegerv(GL_CURRENT_PROGRAM, &s->program);
    glGetIntegerv(GL_VERTEX_ARRAY_BINDING, &s->vertex_array);
    glGetIntegerv(GL_VIEWPORT, s->viewport);
    glGetIntegerv(GL_CLIP_ORIGIN, &s->clip_origin);
    glGetIntegerv(GL_CLIP_DEPTH_MODE, &s->clip_depth);
    glGetIntegerv(GL_DEPTH_FUNC, &s->depth_func);
    glGetIntegerv(GL_CULL_FACE_MODE, &s->cull_mode);
    glGetIntegerv(GL_FRONT_FACE, &s->front_face);
    glGetIntegerv(GL_ACTIVE_TEXTURE, &s->active_texture);
    glGetBooleanv(GL_DEPTH_WRITEMASK, &s->depth_mask);
    glGetBooleanv(GL_COLOR_WRITEMASK, s->color_mask);
    s->depth_test = glIsEnabled(GL_DEPTH_TEST);
    s->cull_face = glIsEnabled(GL_CULL_FACE);
    s->blend = glIsEnabled(GL_BLEND);
    s->scissor = glIsEnabled(GL_SCISSOR_TEST);
    s->stencil = glIsEnabled(GL_STENCIL_TEST);
    s->srgb = glIsEnabled(GL_FRAMEBUFFER_SRGB);
}

static void set_enabled(GLenum what, GLboolean on)
{
    if (on) glEnable(what);
    else glDisable(what);
}

void frame_state_restore(const struct frame_state *s)
{
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, (GLuint)s->framebuffer);
    glUseProgram((GLuint)s->program);
    glBindVertexArray((GLuint)s->vertex_array);
    glViewport(s->viewport[0], s->viewport[1], s->viewport[2], s->viewport[3]);
    glClipControl((GLenum)s->clip_origin, (GLenum)s->clip_depth);
    glDepthFunc((GLenum)s->depth_func);
    glCullFace((GLenum)s->cull_mode);
    glFrontFace((GLenum)s->front_face);
    glActiveTexture((GLenum)s->active_texture);
    glDepthMask(s->depth_mask);
    glColorMask(s->color_mask[0], s->color_mask[1], s->color_mask[2], s->color_mask[3]);
    set_enabled(GL_DEPTH_TEST, s->depth_test);
    set_enabled(GL_CULL_FACE, s->cull_face);
    set_enabled(GL_BLEND, s->blend);
    set_enabled(GL_SCISSOR_TEST, s->scissor);
    set_enabled(GL_STENCIL_TEST, s->stencil);
    set_enabled(GL_FRAMEBUFFER_SRGB, s->srgb);
}
