/* tetrakis for C: tessellation to a tolerance, and view-dependent LOD of terrains, planets and
 * subdivision surfaces.
 *
 * Handles are opaque and freed by their own function, which takes NULL, too. No exception leaves a function: one that
 * can fail returns a tetrakis_status, and tetrakis_last_error() has the sentence. A function that failed has changed
 * nothing, and its results are not written.
 *
 * Structs that callers fill begin with their own size (but for tetrakis_region): set it with the initialiser that is named beside each. So
 * programs work with later versions, whose structs are longer.
 *
 * Each comment ends with who may call the function, and how long its results live:
 *   Any thread.             At any time, and several threads at the same time, with the same handles, too.
 *   One thread a view.      At any time, but calls with the same view exclude each other.
 *   After all other calls.  With this handle: none runs, and none follows.
 *   Until X().              The result is valid until that call; a handle is to be freed by it.
 * Arguments are copied, or are not needed after the call, where nothing else is said.
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

/* "0.1.0". Any thread. Until the program ends. */
TETRAKIS_API const char* tetrakis_version(void);
/* Why this thread's last call that failed did; "" where none has. Any thread. Until this thread's next call. */
TETRAKIS_API const char* tetrakis_last_error(void);

/* ---- Tessellation ---- */

typedef struct tetrakis_control_mesh tetrakis_control_mesh;

/* An OBJ file, with its creases, corners, holes, groups and UVs. Any thread. Until tetrakis_free_control_mesh(). */
TETRAKIS_API tetrakis_status tetrakis_load_control_mesh(const char* path, tetrakis_control_mesh** mesh);
/* Polygons, counter-clockwise from outside: face f has face_sizes[f] vertices.
 * positions: 3 numbers for each of vertex_count vertices; face_vertices: as many numbers as face_sizes add up to.
 * Any thread. Until tetrakis_free_control_mesh(). */
TETRAKIS_API tetrakis_status tetrakis_make_control_mesh(const double* positions, uint32_t vertex_count,
                                                        const uint32_t* face_sizes, uint32_t face_count,
                                                        const uint32_t* face_vertices, tetrakis_control_mesh** mesh);
/* After all other calls. */
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

/* Adaptive triangles, without cracks, as `tetrakis tessellate --no-measure` makes them. Schemes of triangles take
 * triangles only. Any thread. Until tetrakis_free_mesh(). */
TETRAKIS_API tetrakis_status tetrakis_tessellate(const tetrakis_control_mesh* control,
                                                 const tetrakis_tessellate_options* options, tetrakis_mesh** mesh);

/* A mesh as graphics cards draw it. */
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

/* Arrays are the mesh's own. Any thread. Until tetrakis_free_mesh(). */
TETRAKIS_API tetrakis_status tetrakis_get_mesh_arrays(const tetrakis_mesh* mesh, tetrakis_mesh_arrays* arrays);
/* 1: it is within the tolerance, as proven, or as the samples say that refinement took. Any thread. */
TETRAKIS_API int tetrakis_mesh_reached_tolerance(const tetrakis_mesh* mesh);
/* After all other calls. */
TETRAKIS_API void tetrakis_free_mesh(tetrakis_mesh* mesh);

/* ---- LOD ---- */

typedef struct tetrakis_surface tetrakis_surface;
typedef struct tetrakis_view tetrakis_view;

typedef enum tetrakis_height_format {
    TETRAKIS_HEIGHTS_AUTOMATIC = 0, /* by the extension: .png, .hgt, .r16 and .raw, .r32 and .f32; others: GDAL */
    TETRAKIS_HEIGHTS_PNG = 1,       /* grey: the numbers of the pixels; colours: as the next one */
    TETRAKIS_HEIGHTS_TERRAIN_RGB = 2,
    TETRAKIS_HEIGHTS_RAW16 = 3,     /* unsigned numbers of 16 bits and nothing else */
    TETRAKIS_HEIGHTS_RAW_FLOAT = 4, /* floats of 32 bits and nothing else */
    TETRAKIS_HEIGHTS_HGT = 5,
    TETRAKIS_HEIGHTS_GDAL = 6
} tetrakis_height_format;
/* What becomes of samples without data. */
typedef enum tetrakis_gaps {
    TETRAKIS_GAPS_REFUSED = 0, /* TETRAKIS_INVALID_INPUT */
    TETRAKIS_GAPS_FILLED = 1,  /* heights from those around; all of the file is in memory for that */
    TETRAKIS_GAPS_LEVEL = 2    /* they are at gap_height */
} tetrakis_gaps;

/* How a file's heights are read. */
typedef struct tetrakis_height_options {
    size_t size;
    double spacing[2];      /* from a column to the next, from a row to the next; both 0: the file's own, or 1 */
    double scale, offset;   /* a height is offset + scale times the file's number */
    int format;             /* a tetrakis_height_format */
    uint32_t columns, rows; /* of raw files; 0: square, or what the file's size leaves for the other one */
    int big_endian;         /* of raw files: high byte first */
    int has_no_data;        /* no_data counts; HGT and GDAL's files have their own */
    double no_data;         /* the file's number for no data */
    int gaps;               /* a tetrakis_gaps */
    float gap_height;
} tetrakis_height_options;
#define TETRAKIS_HEIGHT_OPTIONS \
    { sizeof(tetrakis_height_options), {0, 0}, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0 }

/* Heights from a file, in memory. x runs east, y north, z up. options: NULL: as TETRAKIS_HEIGHT_OPTIONS has them.
 * Any thread. Until tetrakis_free_surface(). */
TETRAKIS_API tetrakis_status tetrakis_load_terrain(const char* path, const tetrakis_height_options* options,
                                                   tetrakis_surface** surface);
/* Heights row by row from the north, each from the west: columns * rows. Sample (0, 0) is at x = y = 0.
 * Any thread. Until tetrakis_free_surface(). */
TETRAKIS_API tetrakis_status tetrakis_make_terrain(const float* heights, uint32_t columns, uint32_t rows,
                                                   double spacing, tetrakis_surface** surface);
/* Cuts heights of any size, read as tetrakis_load_terrain() does, into a file of tiles. Raw files, HGT and GDAL's
 * rasters are not in memory at once. Any thread, but one at a time for the same tiles_path. */
TETRAKIS_API tetrakis_status tetrakis_write_tiles(const char* heights_path, const tetrakis_height_options* options,
                                                  const char* tiles_path);
/* Such a file as a surface: tiles are loaded by a thread of its own as views ask for them, no call waits, and
 * cache_bytes are never exceeded. Any thread. Until tetrakis_free_surface(), before which nobody
 * changes the file. */
TETRAKIS_API tetrakis_status tetrakis_open_tiles(const char* tiles_path, uint64_t cache_bytes,
                                                 tetrakis_surface** surface);
/* Heights over a ball about the origin, z to the north pole: columns over longitudes from the antimeridian, rows over
 * latitudes from the north pole, samples in the middles of equal cells.
 * level: finest triangles, 2^(level + 1) to a side of each of a cube's faces; 0: as fine as the heights
 * Any thread. Until tetrakis_free_surface(). */
TETRAKIS_API tetrakis_status tetrakis_make_planet(const float* heights, uint32_t columns, uint32_t rows, double radius,
                                                  int level, tetrakis_surface** surface);
/* The same from the faces of a cube, side * side heights each, towards +x, -x, +y, -y, +z, -z, as OpenGL's cube maps
 * have them; first and last rows and columns are on the cube's edges. Any thread. Until tetrakis_free_surface(). */
TETRAKIS_API tetrakis_status tetrakis_make_cube_planet(const float* const faces[6], uint32_t side, double radius,
                                                       int level, tetrakis_surface** surface);

/* Heights that are computed where they are asked for. Functions get `user`, give the same number each time for the same
 * arguments, may be called by any threads at once, and neither throw nor jump. They and `user` live as long as the
 * surfaces that are made of them. */
typedef struct tetrakis_procedural_heights {
    size_t size;
    double (*height)(void* user, const double place[3]); /* from low to high */
    /* How far heights over a triangle in space, in a ball of this radius, are at most from the plane between those at
     * its corners. Does not fall as radii grow. Where it says too little, a view's pixel_error is wrong. */
    double (*deviation)(void* user, double radius);
    void* user;
    double slope; /* the most that a height changes along a way, as a part of its length */
    double low, high;
} tetrakis_procedural_heights;
#define TETRAKIS_PROCEDURAL_HEIGHTS \
    { sizeof(tetrakis_procedural_heights), NULL, NULL, NULL, 0, 0, 0 }

/* Waves in random directions: `octaves` layers, from 1 to 48, each with half the wavelength and half the height of the
 * one before; `amplitude` and `wavelength` are the first one's. Any thread. Until tetrakis_free_fractal_heights(). */
TETRAKIS_API tetrakis_status tetrakis_make_fractal_heights(double amplitude, double wavelength, int octaves,
                                                           uint64_t seed, tetrakis_procedural_heights* heights);
/* Those of the function above; others, or none, are left as they are. After all other calls, also with surfaces. */
TETRAKIS_API void tetrakis_free_fractal_heights(tetrakis_procedural_heights* heights);
/* A square about the origin, heights along z at (x, y, 0). Triangles with sides of `finest` or less are not split.
 * Nothing is stored. Any thread. Until tetrakis_free_surface(). */
TETRAKIS_API tetrakis_status tetrakis_make_procedural_plane(double side, double finest,
                                                            const tetrakis_procedural_heights* heights,
                                                            tetrakis_surface** surface);
/* A ball about the origin, heights outwards, at places on the ball. Any thread. Until tetrakis_free_surface(). */
TETRAKIS_API tetrakis_status tetrakis_make_procedural_ball(double radius, double finest,
                                                           const tetrakis_procedural_heights* heights,
                                                           tetrakis_surface** surface);
/* The limit surface of a scheme on quads, of doo-sabin, midedge or loop, down to 2^(level + 1) triangles to an edge of
 * the control mesh. The control mesh may be freed afterwards. Any thread. Until tetrakis_free_surface(). */
TETRAKIS_API tetrakis_status tetrakis_make_subdivision_surface(const tetrakis_control_mesh* control, const char* scheme,
                                                               int level, tetrakis_surface** surface);
/* After all other calls, also with its views. */
TETRAKIS_API void tetrakis_free_surface(tetrakis_surface* surface);

/* 1, and a terrain's full-resolution height and upward normal, of length one; 0: beside it, or it is no terrain, or
 * one of tiles whose finest tile there is not loaded yet; asking makes it be loaded. Any thread. */
TETRAKIS_API int tetrakis_surface_at(const tetrakis_surface* surface, double x, double y, double* height,
                                     double normal[3]);
/* 1, and where a ray meets the full-resolution surface first: origin + t * direction, t up to `farthest`; 0: nowhere.
 * direction: of a length from 1e-100 to 1e100. normal: of the triangle there, of length one; may be NULL. Any thread. */
TETRAKIS_API int tetrakis_surface_hit(const tetrakis_surface* surface, const double origin[3],
                                      const double direction[3], double farthest, double* t, double normal[3]);

/* 1, and how high a planet's ground is above its ball in a direction, and the normal there, of length one, outwards;
 * 0: no direction, or no planet. Any thread. */
TETRAKIS_API int tetrakis_planet_at(const tetrakis_surface* surface, const double direction[3], double* height,
                                    double normal[3]);
/* Grows whenever a tile has been loaded: the next update of a view then gets on. 0: no tiles. Any thread. */
TETRAKIS_API uint64_t tetrakis_surface_revision(const tetrakis_surface* surface);

typedef struct tetrakis_tile_statistics {
    size_t size;
    uint64_t loads, failures; /* tiles so far; those that could not be read are tried again */
    uint64_t wanted;          /* tiles that were asked for and are not there yet */
    uint64_t cached_bytes;
    const char* last_error; /* "": no failure. Until this thread's next call of the function below */
} tetrakis_tile_statistics;
#define TETRAKIS_TILE_STATISTICS \
    { sizeof(tetrakis_tile_statistics), 0, 0, 0, 0, NULL }

/* How loading goes; a surface without tiles is TETRAKIS_INVALID_INPUT. Any thread. */
TETRAKIS_API tetrakis_status tetrakis_get_tile_statistics(const tetrakis_surface* surface,
                                                          tetrakis_tile_statistics* statistics);

typedef struct tetrakis_view_options {
    size_t size;
    uint32_t max_leaves;   /* room for so many triangles, and never more, or for the roots */
    uint64_t max_bytes;    /* fewer if they would take more; 0: no limit */
    uint32_t max_ranges;   /* of each buffer, an update */
    double outside_weight; /* errors out of sight count this much: 0 to 1 */
    double hysteresis;     /* triangles are merged where the error looks this small a part of the limit: 0.1 to 0.8 */
} tetrakis_view_options;
#define TETRAKIS_VIEW_OPTIONS \
    { sizeof(tetrakis_view_options), 200000, 0, 4096, 0.25, 0.8 }

/* Several views of a surface do not know of each other. Any thread. Until tetrakis_free_view(). */
TETRAKIS_API tetrakis_status tetrakis_make_view(const tetrakis_surface* surface, const tetrakis_view_options* options,
                                                tetrakis_view** view);
/* After all other calls. */
TETRAKIS_API void tetrakis_free_view(tetrakis_view* view);

/* A ball in which errors count `boost` times, from 1 on: around a player, or where things collide. */
typedef struct tetrakis_region {
    double center[3], radius, boost;
} tetrakis_region;
/* Those of a view, in place of the ones before. The next update looks at all triangles. One thread a view. */
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
    const tetrakis_range* vertex_ranges; /* what to upload */
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

/* Follows the camera. Ranges are the view's own. One thread a view. Until its next tetrakis_update_view() or
 * tetrakis_free_view(). */
TETRAKIS_API tetrakis_status tetrakis_update_view(tetrakis_view* view, const tetrakis_camera* camera,
                                                  const tetrakis_budget* budget, tetrakis_update* update);

/* The vertex buffer, the view's own. Its count is never above the capacity, which is fixed. One thread a view. Until
 * the view's next tetrakis_update_view(), tetrakis_set_view_origin() or tetrakis_free_view(). */
TETRAKIS_API const tetrakis_vertex* tetrakis_view_vertices(const tetrakis_view* view, uint32_t* count,
                                                           uint32_t* capacity);
/* The same of triangles: three vertex numbers each; those not in use are all zero. What is beyond the count is not
 * drawn. One thread a view. Until as above. */
TETRAKIS_API const uint32_t* tetrakis_view_triangles(const tetrakis_view* view, uint32_t* count, uint32_t* capacity);
typedef struct tetrakis_snapshot tetrakis_snapshot;
/* The triangles as they are now, without morphing, for queries of any thread: a copy. O(triangles log triangles).
 * One thread a view. Until tetrakis_free_snapshot(); the view may be freed before. */
TETRAKIS_API tetrakis_status tetrakis_take_snapshot(const tetrakis_view* view, tetrakis_snapshot** snapshot);
/* Writes it as a mesh, .obj, .ply or .glb, in the surface's own frame. Any thread. */
TETRAKIS_API tetrakis_status tetrakis_write_snapshot(const tetrakis_snapshot* snapshot, const char* path);
/* After all other calls. */
TETRAKIS_API void tetrakis_free_snapshot(tetrakis_snapshot* snapshot);
/* As tetrakis_surface_hit(), in the surface's own frame, but in single precision: a ray right through a vertex may meet
 * nothing. Any thread. */
TETRAKIS_API int tetrakis_snapshot_hit(const tetrakis_snapshot* snapshot, const double origin[3],
                                       const double direction[3], double farthest, double* t, double normal[3]);
/* Positions are about it: choose one near the eye where the world is large. All vertices change. One thread a view. */
TETRAKIS_API tetrakis_status tetrakis_set_view_origin(tetrakis_view* view, const double origin[3]);

#ifdef __cplusplus
}
#endif

#endif
