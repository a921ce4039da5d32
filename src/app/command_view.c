#include "app/command.h"

#include <math.h>

#include "app/session.h"
#include "app/window.h"
#include "base/log.h"
#include "gpu/program.h"

status command_view(const struct options *o)
{
    struct session session;
    struct window_params params = {.vsync = true};
    if (!window_display_available()) {
        log_error("view: no display answers (DISPLAY, WAYLAND_DISPLAY); render and fly need none");
        return ERR_GPU;
    }
    status s = session_open_planet(o, &session);
    if (!s) s = session_camera(&session, &params.start);
    if (!s) {
        gpu_program_set_dir(o->shader_dir);
        params.planet = session.planet;
        params.view = &o->view_params;
        params.width = o->width;
        params.height = o->height;
        params.unix_time_s = o->time_given ? o->unix_time_s : NAN;
        params.attribution = session.info.attribution;
        if (window_run(&params) != 0) s = ERR_GPU;
        else session_credit(&session);
    }
    session_close(&session);
    return s;
}
