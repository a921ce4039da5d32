#include "app/views_file.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/camera_json.h"
#include "app/camera_string.h"
#include "base/log.h"
#include "base/memory.h"

enum { MAX_VIEWS = 10000 };

static status refuse_name(struct json_place at, const char *what)
{
    log_error("%s: %s: \"name\" %s", at.path, at.where, what);
    return ERR_FORMAT;
}

static status read_name(struct json_place at, const cJSON *object, named_view *view)
{
    const char *name;
    status s = json_text(at, object, "name", &name);
    if (s) return s;
    if (!name || !name[0]) return refuse_name(at, "is missing or empty");
    if (strlen(name) >= sizeof view->name) return refuse_name(at, "is longer than 63 bytes");
    snprintf(view->name, sizeof view->name, "%s", name);
    return OK;
}

static status read_view(struct json_place at, const cJSON *object, double fov_deg, named_view *view)
{
    static const char *const members[] = {"name",    "lat",   "lon",  "alt", "aboveGround",
                                          "heading", "pitch", "roll", "fov"};
    status s = json_check_object(at, object);
    if (!s) s = json_check_members(at, object, members, sizeof members / sizeof members[0]);
    if (!s) s = read_name(at, object, view);
    if (s) return s;
    char where[128];
    snprintf(where, sizeof where, "%s, '%s'", at.where, view->name);
    view->camera.fov_deg = fov_deg;
    return camera_json_read((struct json_place){at.path, where}, object, &view->camera,
                            &view->above_ground);
}

static bool has_name_before(const struct views_file *file, int i)
{
    for (int k = 0; k < i; k++)
        if (strcmp(file->views[k].name, file->views[i].name) == 0) return true;
    return false;
}

static status read_views(const char *path, const cJSON *views, double fov_deg,
                         struct views_file *out)
{
    int count = cJSON_IsArray(views) ? cJSON_GetArraySize(views) : 0;
    if (count < 1 || count > MAX_VIEWS) {
        log_error("%s: \"views\" is not a list of 1 to %d views", path, MAX_VIEWS);
        return ERR_FORMAT;
    }
    out->views = NEW_ARRAY(named_view, (size_t)count);
    const cJSON *object;
    cJSON_ArrayForEach(object, views)
    {
        char where[32];
        struct json_place at = {path, where};
        snprintf(where, sizeof where, "view %d", out->count + 1);
        status s = read_view(at, object, fov_deg, &out->views[out->count]);
        if (!s && has_name_before(out, out->count)) s = refuse_name(at, "is another view's");
        if (s) return s;
        out->count++;
    }
    return OK;
}

static status read_root(const char *path, const cJSON *root, struct views_file *out)
{
    static const char *const members[] = {"name", "fov", "views"};
    struct json_place at = {path, ""};
    const char *name;
    double fov_deg = CAMERA_JSON_FOV;
    status s = json_check_members(at, root, members, sizeof members / sizeof members[0]);
    if (!s) s = json_text(at, root, "name", &name);
    if (!s) s = json_number(at, root, "fov", CAMERA_FOV_MIN, CAMERA_FOV_MAX, false, &fov_deg);
    if (s) return s;
    snprintf(out->name, sizeof out->name, "%s", name ? name : path);
    snprintf(out->path, sizeof out->path, "%s", path);
    return read_views(path, cJSON_GetObjectItemCaseSensitive(root, "views"), fov_deg, out);
}

status views_file_load(const char *path, struct views_file *out)
{
    *out = (struct views_file){0};
    cJSON *root;
    status s = json_file_load(path, &root);
    if (!s) s = read_root(path, root, out);
    if (s) views_file_deinit(out);
    cJSON_Delete(root);
    return s;
}

void views_file_deinit(struct views_file *file)
{
    free(file->views);
    *file = (struct views_file){0};
}
