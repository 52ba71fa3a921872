/* An engine's loop: fly over a terrain, upload changes, keep the player on the ground. Then tessellate a model.
 *   engine_loop HEIGHTS.png MODEL.obj */
#include "tetrakis_c.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void check(tetrakis_status status) {
    if (status == TETRAKIS_OK) return;
    fprintf(stderr, "engine_loop: %s\n", tetrakis_last_error());
    exit(1);
}

/* Here an engine copies into buffers of the graphics card. */
static void upload(void* buffer, const void* from, size_t size, const tetrakis_range* ranges, uint32_t count) {
    for (uint32_t i = 0; i < count; ++i)
        memcpy((char*)buffer + size * ranges[i].first, (const char*)from + size * ranges[i].first,
               size * ranges[i].count);
}

static void fly(const char* heights) {
    tetrakis_surface* surface;
    tetrakis_view* view;
    const tetrakis_view_options options = TETRAKIS_VIEW_OPTIONS;
    tetrakis_height_options reading = TETRAKIS_HEIGHT_OPTIONS;
    reading.spacing[0] = reading.spacing[1] = 10;
    reading.scale = 0.1;
    check(tetrakis_load_terrain(heights, &reading, &surface));
    check(tetrakis_make_view(surface, &options, &view));
    uint32_t vertices, triangles, count;
    tetrakis_view_vertices(view, &count, &vertices);
    tetrakis_view_triangles(view, &count, &triangles);
    tetrakis_vertex* vertex_buffer = calloc(vertices, sizeof *vertex_buffer);
    uint32_t* index_buffer = calloc(triangles, 3 * sizeof *index_buffer);

    tetrakis_camera camera = TETRAKIS_CAMERA;
    tetrakis_budget budget = TETRAKIS_BUDGET;
    tetrakis_update update = TETRAKIS_UPDATE;
    budget.milliseconds = 4;
    unsigned long changes = 0;
    for (int frame = 0; frame < 300; ++frame) {
        camera.eye[0] = 640 + 300 * cos(0.01 * frame);
        camera.eye[1] = -640 + 300 * sin(0.01 * frame);
        double ground = 0;
        tetrakis_surface_at(surface, camera.eye[0], camera.eye[1], &ground, NULL);
        camera.eye[2] = ground + 20;
        camera.direction[0] = -sin(0.01 * frame);
        camera.direction[1] = cos(0.01 * frame);
        check(tetrakis_update_view(view, &camera, &budget, &update));
        upload(vertex_buffer, tetrakis_view_vertices(view, &count, NULL), sizeof *vertex_buffer, update.vertex_ranges,
               update.vertex_range_count);
        upload(index_buffer, tetrakis_view_triangles(view, &count, NULL), 3 * sizeof *index_buffer,
               update.triangle_ranges, update.triangle_range_count);
        /* draw(vertex_buffer, index_buffer, count, update.morph_scale) */
        changes += update.splits + update.merges;
    }
    const uint32_t* indices = tetrakis_view_triangles(view, &count, NULL);
    int same = memcmp(index_buffer, indices, 3 * sizeof *indices * count) == 0;
    const tetrakis_vertex* all = tetrakis_view_vertices(view, &count, NULL);
    same = same && memcmp(vertex_buffer, all, sizeof *all * count) == 0;
    printf("%u triangles, %lu changes, the copy is %s\n", update.leaves, changes, same ? "the same" : "another");
    free(vertex_buffer);
    free(index_buffer);
    tetrakis_free_view(view);
    tetrakis_free_surface(surface);
}

static void tessellate(const char* model) {
    tetrakis_control_mesh* control;
    tetrakis_mesh* mesh;
    const tetrakis_tessellate_options options = TETRAKIS_TESSELLATE_OPTIONS;
    tetrakis_mesh_arrays arrays = TETRAKIS_MESH_ARRAYS;
    check(tetrakis_load_control_mesh(model, &control));
    check(tetrakis_tessellate(control, &options, &mesh));
    check(tetrakis_get_mesh_arrays(mesh, &arrays));
    printf("%u vertices, %u triangles, within the tolerance: %s\n", arrays.vertex_count, arrays.triangle_count,
           tetrakis_mesh_reached_tolerance(mesh) ? "yes" : "no");
    tetrakis_free_mesh(mesh);
    tetrakis_free_control_mesh(control);
}

int main(int argc, char** argv) {
    if (argc != 3) {
        fprintf(stderr, "usage: engine_loop HEIGHTS.png MODEL.obj\n");
        return 2;
    }
    fly(argv[1]);
    tessellate(argv[2]);
    return 0;
}
