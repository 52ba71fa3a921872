/* tetrakis for C: tessellation to a tolerance, and view-dependent LOD of terrains, planets and
 * subdivision surfaces.
 *
 * Handles are opaque and freed by their own function, which takes NULL, too. No exception leaves a function: one that
 * can fail returns a tetrakis_status, and tetrakis_last_error() has the sentence. A function that failed has changed
 * nothing, and its results are not written.
 *
 * Structs that callers fill begin with their own size: set it with the initialiser that is named beside each. So
 * programs work with later versions, whose structs are longer.
 *
 * Threads: control meshes, meshes, surfaces and snapshots do not change: any number of threads may read them at the
 * same time, and one frees them when none does. A surface is freed after its views. A view is for one thread at a time:
 * functions that take a `tetrakis_view*`, tetrakis_take_snapshot() too, exclude each other for the same view. What a
 * function returns pointers to lives as long as the handle, but where its comment says less.
 */
#ifndef TETRAKIS_C_H
#define TETRAKIS_C_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(_WIN32)
#    define TETRAKIS_API
#else
#    define TETRAKIS_API __attribute__((visibility("default")))
#endif

typedef enum tetrakis_status {
    TETRAKIS_OK = 0,
    TETRAKIS_INVALID_INPUT = 1, /* the file or the numbers make no sense */
    TETRAKIS_IO = 2,            /* a file cannot be read or written */
    TETRAKIS_UNSUPPORTED = 3,
    TETRAKIS_MEMORY_LIMIT = 4, /* or none is left */
    TETRAKIS_FAILURE = 5       /* a fault of the library */
} tetrakis_status;

/* "0.1.0". */
TETRAKIS_API const char* tetrakis_version(void);
/* Why this thread's last call that failed did; "" where none has. Valid until this thread's next call. */
TETRAKIS_API const char* tetrakis_last_error(void);

/* ---- Tessellation ---- */

typedef struct tetrakis_control_mesh tetrakis_control_mesh;

/* An OBJ file, with its creases, corners, holes, groups and UVs. */
TETRAKIS_API tetrakis_status tetrakis_load_control_mesh(const char* path, tetrakis_control_mesh** mesh);
/* Polygons, counter-clockwise from outside: face f has face_sizes[f] vertices. Arrays are copied.
 * positions: 3 numbers for each of vertex_count vertices; face_vertices: as many numbers as face_sizes add up to. */
TETRAKIS_API tetrakis_status tetrakis_make_control_mesh(const double* positions, uint32_t vertex_count,
                                                        const uint32_t* face_sizes, uint32_t face_count,
                                                        const uint32_t* face_vertices, tetrakis_control_mesh** mesh);
TETRAKIS_API void tetrakis_free_control_mesh(tetrakis_control_mesh* mesh);

typedef struct tetrakis_tessellate_options {
    size_t size;
    const char* scheme;     /* "catmull-clark", "loop" ...: `tetrakis schemes` lists them */
    double tolerance;       /* of the mesh's distance from the limit surface; 0: none, max_triangles alone */
    int absolute;           /* the tolerance is a length; else a part of the control mesh's diagonal */
    int certified;          /* the tolerance is proven, not measured; some more triangles */
    uint64_t max_triangles; /* 0: no limit */
    int threads;            /* 0: all */
} tetrakis_tessellate_options;
#define TETRAKIS_TESSELLATE_OPTIONS \
    { sizeof(tetrakis_tessellate_options), "catmull-clark", 1e-3, 0, 0, 0, 0 }

typedef struct tetrakis_mesh tetrakis_mesh;

/* Adaptive triangles, without cracks. Takes the time that `tetrakis tessellate` takes. */
TETRAKIS_API tetrakis_status tetrakis_tessellate(const tetrakis_control_mesh* control,
                                                 const tetrakis_tessellate_options* options, tetrakis_mesh** mesh);

/* A mesh as graphics cards draw it. Arrays are the mesh's own. */
typedef struct tetrakis_mesh_arrays {
    size_t size;
    uint32_t vertex_count, triangle_count;
    const float* positions;  /* 3 for each vertex, about `origin` */
    const float* normals;    /* 3 for each vertex */
    const float* uvs;        /* 2 for each vertex; NULL: there are none */
    const uint32_t* indices; /* 3 for each triangle */
    double origin[3];
} tetrakis_mesh_arrays;
#define TETRAKIS_MESH_ARRAYS                                                    \
    {                                                                           \
        sizeof(tetrakis_mesh_arrays), 0, 0, NULL, NULL, NULL, NULL, { 0, 0, 0 } \
    }

TETRAKIS_API tetrakis_status tetrakis_get_mesh_arrays(const tetrakis_mesh* mesh, tetrakis_mesh_arrays* arrays);
/* 1: it is within the tolerance. */
TETRAKIS_API int tetrakis_mesh_reached_tolerance(const tetrakis_mesh* mesh);
TETRAKIS_API void tetrakis_free_mesh(tetrakis_mesh* mesh);

/* ---- LOD ---- */

typedef struct tetrakis_surface tetrakis_surface;
typedef struct tetrakis_view tetrakis_view;

/* Heights from a file (PNG, terrain-RGB, HGT ...); a height is offset + scale times the file's number. Samples without
 * data are filled. spacing: between samples; 0: the file's own, or 1. x runs east, y north, z up. */
TETRAKIS_API tetrakis_status tetrakis_load_terrain(const char* path, double spacing, double scale, double offset,
                                                   tetrakis_surface** surface);
/* Heights row by row from the north, each from the west: columns * rows, copied. Sample (0, 0) is at x = y = 0. */
TETRAKIS_API tetrakis_status tetrakis_make_terrain(const float* heights, uint32_t columns, uint32_t rows,
                                                   double spacing, tetrakis_surface** surface);
/* Cuts heights of any size, read as tetrakis_load_terrain() does but not filled, into a file of tiles. Raw files, HGT
 * and GDAL's rasters are not in memory at once. */
TETRAKIS_API tetrakis_status tetrakis_write_tiles(const char* heights_path, double spacing, double scale, double offset,
                                                  const char* tiles_path);
/* Such a file as a surface: tiles are loaded by a thread of its own as views ask for them, no call waits, and
 * cache_bytes are never exceeded. */
TETRAKIS_API tetrakis_status tetrakis_open_tiles(const char* tiles_path, uint64_t cache_bytes,
                                                 tetrakis_surface** surface);
/* Heights over a ball about the origin, z to the north pole: columns over longitudes from the antimeridian, rows over
 * latitudes from the north pole, samples in the middles of equal cells; copied.
 * level: finest triangles, 2^(level + 1) to a side of each of a cube's faces; 0: as fine as the heights */
TETRAKIS_API tetrakis_status tetrakis_make_planet(const float* heights, uint32_t columns, uint32_t rows, double radius,
                                                  int level, tetrakis_surface** surface);
/* The limit surface of a scheme on quads, or of "loop", down to 2^(level + 1) triangles to an edge of the control mesh.
 * The control mesh may be freed afterwards. */
TETRAKIS_API tetrakis_status tetrakis_make_subdivision_surface(const tetrakis_control_mesh* control, const char* scheme,
                                                               int level, tetrakis_surface** surface);
TETRAKIS_API void tetrakis_free_surface(tetrakis_surface* surface);

/* 1, and a terrain's full-resolution height and upward normal, of length one; 0: beside it, or it is no terrain, or
 * one of tiles whose finest tile there is not loaded yet; asking makes it be loaded. Any thread, any time. */
TETRAKIS_API int tetrakis_surface_at(const tetrakis_surface* surface, double x, double y, double* height,
                                     double normal[3]);
/* 1, and where a ray meets the full-resolution surface first: origin + t * direction, t up to `farthest`; 0: nowhere.
 * Any thread, any time. */
TETRAKIS_API int tetrakis_surface_hit(const tetrakis_surface* surface, const double origin[3],
                                      const double direction[3], double farthest, double* t);

typedef struct tetrakis_view_options {
    size_t size;
    uint32_t max_leaves;   /* room for so many triangles, and never more, or for the roots */
    uint64_t max_bytes;    /* fewer if they would take more; 0: no limit */
    uint32_t max_ranges;   /* of each buffer, an update */
    double outside_weight; /* errors out of sight count this much: 0 to 1 */
    double hysteresis;     /* triangles are merged where the error looks this small a part of the limit: 0.1 to 0.8 */
} tetrakis_view_options;
#define TETRAKIS_VIEW_OPTIONS \
    { sizeof(tetrakis_view_options), 200000, 0, 4096, 0.25, 0.7 }

TETRAKIS_API tetrakis_status tetrakis_make_view(const tetrakis_surface* surface, const tetrakis_view_options* options,
                                                tetrakis_view** view);
TETRAKIS_API void tetrakis_free_view(tetrakis_view* view);

/* A ball in which errors count `boost` times, from 1 on: around a player, or where things collide. */
typedef struct tetrakis_region {
    double center[3], radius, boost;
} tetrakis_region;
/* Those of a view, in place of the ones before; copied. The next update looks at all triangles. */
TETRAKIS_API tetrakis_status tetrakis_set_view_regions(tetrakis_view* view, const tetrakis_region* regions,
                                                       uint32_t count);

typedef struct tetrakis_camera {
    size_t size;
    double eye[3], direction[3], up[3];
    double vertical_fov;    /* radians */
    uint32_t width, height; /* pixels */
} tetrakis_camera;
#define TETRAKIS_CAMERA \
    { sizeof(tetrakis_camera), {0, 0, 0}, {0, 1, 0}, {0, 0, 1}, 1, 1920, 1080 }

typedef struct tetrakis_budget {
    size_t size;
    double pixel_error;  /* triangles whose error looks larger are split */
    uint32_t leaves;     /* most triangles */
    double milliseconds; /* an update ends soon after this, and the next one goes on; 0: no limit. Triangles
                            beyond `leaves` are merged first, however long that takes */
} tetrakis_budget;
#define TETRAKIS_BUDGET \
    { sizeof(tetrakis_budget), 1, UINT32_MAX, 0 }

/* What is drawn. In a vertex shader, with d the distance from the eye:
 *   w = clamp((d / (error * morph_scale) - 0.85) / 0.15, 0, 1), shown at mix(position, on_edge, w). */
typedef struct tetrakis_vertex {
    float position[3]; /* about the view's origin */
    float on_edge[3];
    int16_t normal[2]; /* octahedral, 32767 is 1 */
    float uv[2];
    float error;
} tetrakis_vertex;

typedef struct tetrakis_range {
    uint32_t first, count;
} tetrakis_range;

typedef struct tetrakis_update {
    size_t size;
    const tetrakis_range* vertex_ranges; /* what to upload; the view's own, until its next call */
    const tetrakis_range* triangle_ranges;
    uint32_t vertex_range_count, triangle_range_count;
    uint32_t splits, merges, leaves;
    double pixel_error; /* no triangle's error looks larger */
    double morph_scale;
    int complete;     /* the time did suffice */
    uint32_t waiting; /* diamonds that are not loaded yet and stay as they are */
} tetrakis_update;
#define TETRAKIS_UPDATE \
    { sizeof(tetrakis_update), NULL, NULL, 0, 0, 0, 0, 0, 0, 0, 0, 0 }

TETRAKIS_API tetrakis_status tetrakis_update_view(tetrakis_view* view, const tetrakis_camera* camera,
                                                  const tetrakis_budget* budget, tetrakis_update* update);

/* The buffers: the view's own, until its next call. Triangles are three vertex numbers; those not in use are all zero.
 * Counts are never above the capacities, which are fixed; what is beyond a count is not drawn. */
TETRAKIS_API const tetrakis_vertex* tetrakis_view_vertices(const tetrakis_view* view, uint32_t* count,
                                                           uint32_t* capacity);
TETRAKIS_API const uint32_t* tetrakis_view_triangles(const tetrakis_view* view, uint32_t* count, uint32_t* capacity);
/* The triangles as they are now, without morphing, for queries of any thread: a copy. O(triangles log triangles). */
typedef struct tetrakis_snapshot tetrakis_snapshot;
TETRAKIS_API tetrakis_status tetrakis_take_snapshot(const tetrakis_view* view, tetrakis_snapshot** snapshot);
TETRAKIS_API void tetrakis_free_snapshot(tetrakis_snapshot* snapshot);
/* As tetrakis_surface_hit(), in the surface's own frame. normal: of the triangle there, of length one; may be NULL. */
TETRAKIS_API int tetrakis_snapshot_hit(const tetrakis_snapshot* snapshot, const double origin[3],
                                       const double direction[3], double farthest, double* t, double normal[3]);
/* Positions are about it: choose one near the eye where the world is large. All vertices change. */
TETRAKIS_API tetrakis_status tetrakis_set_view_origin(tetrakis_view* view, const double origin[3]);

#ifdef __cplusplus
}
#endif

#endif
