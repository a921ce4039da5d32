#include "app/ui.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include <imgui.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>

namespace
{

const ImGuiWindowFlags PASSIVE =
    ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_AlwaysAutoResize |
    ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoSavedSettings;

const float MARGIN = 8;
// Of the list of what is missing as many lines are shown.
const int MISSING_LINES = 4;

struct help_line {
    const char *keys, *what;
};

const help_line HELP[] = {
    {"Left drag", "move the planet under the cursor"},
    {"Wheel", "zoom to the cursor"},
    {"Right or middle drag", "tilt and turn about the point"},
    {"Double click", "fly there"},
    {"Arrows", "move"},
    {"Shift + arrows", "turn and tilt"},
    {"+ / -", "zoom in and out"},
    {"N", "north up"},
    {"Home", "back to the first view"},
    {"Space", "start and stop the time"},
    {", / .", "time slower and faster"},
    {"F", "fly mode; Esc leaves it"},
    {"W A S D, R F, Q E", "in fly mode: move, rise and sink, roll"},
    {"Shift", "in fly mode: faster"},
    {"M", "next mode; in a split of the right half"},
    {"V", "split: two modes at the same camera, and their difference"},
    {"X", "in a split: the difference below, everywhere, nowhere"},
    {"C", "copy the camera (perigee view --camera ...)"},
    {"F12", "screenshot"},
    {"F1", "this help"},
    {"Esc", "quit"},
};

// 950 m, 12.3 km, 20,000 km
void format_length(char *text, size_t size, double m)
{
    if (std::fabs(m) < 10) snprintf(text, size, "%.1f m", m);
    else if (std::fabs(m) < 10e3) snprintf(text, size, "%.0f m", m);
    else if (std::fabs(m) < 1e6) snprintf(text, size, "%.1f km", m / 1e3);
    else snprintf(text, size, "%.0f km", m / 1e3);
}

void format_count(char *text, size_t size, double n)
{
    if (n < 1e4) snprintf(text, size, "%.0f", n);
    else if (n < 1e6) snprintf(text, size, "%.1f k", n / 1e3);
    else snprintf(text, size, "%.2f M", n / 1e6);
}

// Length of the first lines of a text, without the last line's end.
int length_of_lines(const char *text, int lines)
{
    const char *p = text;
    for (const char *end; *p && lines > 0; lines--) {
        end = p + std::strcspn(p, "\n");
        if (lines == 1 || !*end) return (int)(end - text);
        p = end + 1;
    }
    return (int)(p - text);
}

// A window that only shows, held by one of its corners: pivot 0, 0 is its upper left.
void begin_passive(const char *name, ImVec2 at, ImVec2 pivot)
{
    ImGui::SetNextWindowPos(at, ImGuiCond_Always, pivot);
    ImGui::SetNextWindowBgAlpha(0.45f);
    ImGui::Begin(name, nullptr, PASSIVE);
}

void draw_mode(const ui_state *s, int side)
{
    char drawn[32], total[32];
    format_count(drawn, sizeof drawn, (double)s->stats[side].triangles_drawn);
    format_count(total, sizeof total, (double)s->stats[side].triangles_total);
    ImGui::Text("%s: %s of %s triangles", s->modes[side], drawn, total);
}

// What the right half and the lowest rows of a split show.
void draw_split(const ui_state *s, ImVec2 size)
{
    if (!s->modes[1]) return;
    begin_passive("right", ImVec2(size.x - MARGIN, MARGIN), ImVec2(1, 0));
    draw_mode(s, 1);
    ImGui::End();
    if (!(s->difference > 0)) return;
    float top = size.y * (1 - (float)s->difference);
    begin_passive("difference", ImVec2(size.x - MARGIN, top + MARGIN * (top > 0 ? 1 : 5)),
                  ImVec2(1, 0));
    ImGui::Text("difference x %d", s->gain);
    ImGui::End();
}

void draw_position(const ui_state *s)
{
    char alt[32], above[32];
    const perigee_camera &c = s->camera;
    format_length(alt, sizeof alt, c.alt_m);
    format_length(above, sizeof above, c.alt_m - s->ground_m);
    begin_passive("position", ImVec2(MARGIN, MARGIN), ImVec2(0, 0));
    ImGui::Text("%.6f %c  %.6f %c", std::fabs(c.lat_deg), c.lat_deg < 0 ? 'S' : 'N',
                std::fabs(c.lon_deg), c.lon_deg < 0 ? 'W' : 'E');
    ImGui::Text("altitude %s, %s over ground", alt, above);
    ImGui::Text("heading %.1f  pitch %.1f", c.heading_deg < 0 ? c.heading_deg + 360 : c.heading_deg,
                c.pitch_deg);
    ImGui::Text("%s", s->time);
    ImGui::Text("%.1f ms", s->frame_ms);
    draw_mode(s, 0);
    if (s->flying) ImGui::TextUnformatted("fly mode");
    if (s->missing_count > 0) {
        ImGui::Separator();
        ImGui::Text("loading: %d", s->missing_count);
        ImGui::Text("%.*s", length_of_lines(s->missing, MISSING_LINES), s->missing);
    }
    ImGui::End();
}

void draw_attribution(const ui_state *s, ImVec2 size)
{
    if (!s->attribution[0]) return;
    float wrap = size.x - 4 * MARGIN;
    ImVec2 text = ImGui::CalcTextSize(s->attribution, nullptr, false, wrap);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(MARGIN / 2, MARGIN / 4));
    begin_passive("attribution", ImVec2(size.x, size.y), ImVec2(1, 1));
    ImGui::PushTextWrapPos(std::min(text.x + MARGIN, wrap));
    ImGui::TextUnformatted(s->attribution);
    ImGui::PopTextWrapPos();
    ImGui::End();
    ImGui::PopStyleVar();
}

void draw_help(bool *open, ImVec2 size)
{
    if (!*open) return;
    ImGui::SetNextWindowPos(ImVec2(size.x / 2, size.y / 2), ImGuiCond_Appearing,
                            ImVec2(0.5f, 0.5f));
    ImGui::SetNextWindowBgAlpha(0.85f);
    if (ImGui::Begin("Help", open,
                     ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings |
                         ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoNav) &&
        ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) {
        for (const help_line &line : HELP) {
            ImGui::TableNextRow();
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(line.keys);
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(line.what);
        }
        ImGui::EndTable();
    }
    ImGui::End();
}

void lay_out(const ui_state *s)
{
    ImVec2 size = ImGui::GetIO().DisplaySize;
    draw_position(s);
    draw_split(s, size);
    draw_attribution(s, size);
    if (s->message[0]) {
        begin_passive("message", ImVec2(size.x / 2, size.y - 5 * MARGIN), ImVec2(0.5f, 1));
        ImGui::TextUnformatted(s->message);
        ImGui::End();
    }
    draw_help(s->help, size);
}

} // namespace

extern "C" bool ui_init(GLFWwindow *window, float scale)
{
    ImGui::CreateContext();
    ImGui::StyleColorsDark();
    ImGuiIO &io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.LogFilename = nullptr;
    io.FontGlobalScale = scale;
    ImGui::GetStyle().ScaleAllSizes(scale);
    ImGui::GetStyle().WindowBorderSize = 0;
    ImGui::GetStyle().WindowMinSize = ImVec2(1, 1);
    if (!ImGui_ImplGlfw_InitForOpenGL(window, true)) {
        ImGui::DestroyContext();
        return false;
    }
    if (!ImGui_ImplOpenGL3_Init("#version 450")) {
        ImGui_ImplGlfw_Shutdown();
        ImGui::DestroyContext();
        return false;
    }
    return true;
}

extern "C" void ui_deinit(void)
{
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
}

extern "C" void ui_draw(const ui_state *state)
{
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    // Windows take the size that their contents had a frame before: laid out twice, they fit at
    // once.
    ImGui::NewFrame();
    lay_out(state);
    ImGui::EndFrame();
    ImGui::NewFrame();
    lay_out(state);
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

extern "C" bool ui_wants_mouse(void)
{
    return ImGui::GetIO().WantCaptureMouse;
}

extern "C" bool ui_wants_keyboard(void)
{
    return ImGui::GetIO().WantTextInput;
}
