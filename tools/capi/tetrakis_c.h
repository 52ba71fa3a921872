/* tetrakis for C: tessellation to a tolerance, and view-dependent LOD of terrains, planets and
 * subdivision surfaces.
 *
 * Handles are opaque. Each kind has a function that frees it and that accepts NULL. No exception leaves a function: a
 * function that can fail returns a tetrakis_status, and tetrakis_last_error() returns the message. A function that
 * failed has changed nothing and has written no results.
 *
 * Each struct but tetrakis_region, _vertex and _range begins with its own size. Set it with the initialiser that
 * follows the struct, so that programs also work with later versions, whose structs are longer.
 *
 * Each comment ends with who may call the function, and how long its results live:
 *   Any thread.             At any time, also several threads at the same time with the same handles.
 *   One thread a view.      At any time, but no two calls with the same view at the same time.
 *   After all other calls.  No other call with this handle is running, and none follows.
 *   Until X().              The result is valid until that call, which frees it if it is a handle.
 * If nothing else is said, arguments are copied or are not needed after the call.
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
    TETRAKIS_MEMORY_LIMIT = 4, /* a limit would be exceeded, or no memory is left */
    TETRAKIS_FAILURE = 5       /* a fault of the library */
} tetrakis_status;

/* "0.1.0". Any thread. Until the program ends. */
TETRAKIS_API const char* tetrakis_version(void);
/* Message of the last call of this thread that failed; "" if none has. Any thread. Until this thread's next call. */
TETRAKIS_API const char* tetrakis_last_error(void);

/* ---- Tessellation ---- */

typedef struct tetrakis_control_mesh tetrakis_control_mesh;

/* An OBJ file, with its creases, corners, holes, groups and UVs. Any thread. Until tetrakis_free_control_mesh(). */
TETRAKIS_API tetrakis_status tetrakis_load_control_mesh(const char* path, tetrakis_control_mesh** mesh);
/* Makes a control mesh of polygons, counter-clockwise from outside: face f has face_sizes[f] vertices.
 * positions: 3 numbers for each vertex; face_vertices: the vertex numbers of face 0, then of face 1, and so on.
 * Any thread. Until tetrakis_free_control_mesh(). */
TETRAKIS_API tetrakis_status tetrakis_make_control_mesh(const double* positions, uint32_t vertex_count,
                                                        const uint32_t* face_sizes, uint32_t face_count,
                                                        const uint32_t* face_vertices, tetrakis_control_mesh** mesh);
/* After all other calls. */
TETRAKIS_API void tetrakis_free_control_mesh(tetrakis_control_mesh* mesh);

typedef struct tetrakis_tessellate_options {
    size_t size;
    const char* scheme;     /* "catmull-clark", "loop" ...: `tetrakis schemes` lists them */
    double tolerance;       /* largest distance between mesh and limit surface; 0: none, max_triangles alone */
    int absolute;           /* 1: tolerance is a length; 0: a fraction of the control mesh's bounding-box diagonal */
    int certified;          /* 1: the tolerance is proven, with some more triangles; 0: it is measured */
    uint64_t max_triangles; /* 0: no limit */
    int threads;            /* 0: one for each processor */
} tetrakis_tessellate_options;
#define TETRAKIS_TESSELLATE_OPTIONS \
    { sizeof(tetrakis_tessellate_options), "catmull-clark", 1e-3, 0, 0, 0, 0 }

typedef struct tetrakis_mesh tetrakis_mesh;

/* Tessellates the limit surface adaptively and without cracks, as `tetrakis tessellate --no-measure` does. Triangle
 * schemes accept triangles only. Any thread. Until tetrakis_free_mesh(). */
TETRAKIS_API tetrakis_status tetrakis_tessellate(const tetrakis_control_mesh* control,
                                                 const tetrakis_tessellate_options* options, tetrakis_mesh** mesh);

/* Arrays of a mesh, as graphics cards draw it. */
typedef struct tetrakis_mesh_arrays {
    size_t size;
    uint32_t vertex_count, triangle_count;
    const float* positions;  /* 3 for each vertex, relative to `origin` */
    const float* normals;    /* 3 for each vertex */
    const float* uvs;        /* 2 for each vertex; NULL: the mesh has none */
    const uint32_t* indices; /* 3 for each triangle */
    double origin[3];
} tetrakis_mesh_arrays;
#define TETRAKIS_MESH_ARRAYS                                                    \
    {                                                                           \
        sizeof(tetrakis_mesh_arrays), 0, 0, NULL, NULL, NULL, NULL, { 0, 0, 0 } \
    }

/* The arrays belong to the mesh. Any thread. Until tetrakis_free_mesh(). */
TETRAKIS_API tetrakis_status tetrakis_get_mesh_arrays(const tetrakis_mesh* mesh, tetrakis_mesh_arrays* arrays);
/* 1: the mesh is within the tolerance, proven if `certified`, else by the samples of the refinement. Any thread. */
TETRAKIS_API int tetrakis_mesh_reached_tolerance(const tetrakis_mesh* mesh);
/* After all other calls. */
TETRAKIS_API void tetrakis_free_mesh(tetrakis_mesh* mesh);

/* ---- LOD ---- */

typedef struct tetrakis_surface tetrakis_surface;
typedef struct tetrakis_view tetrakis_view;

typedef enum tetrakis_height_format {
    TETRAKIS_HEIGHTS_AUTOMATIC = 0, /* by the extension: .png, .hgt, .r16 and .raw, .r32 and .f32; others: GDAL */
    TETRAKIS_HEIGHTS_PNG = 1,       /* grey: the values of the pixels; coloured: as TETRAKIS_HEIGHTS_TERRAIN_RGB */
    TETRAKIS_HEIGHTS_TERRAIN_RGB = 2,
    TETRAKIS_HEIGHTS_RAW16 = 3,     /* unsigned 16-bit numbers without a header */
    TETRAKIS_HEIGHTS_RAW_FLOAT = 4, /* 32-bit floats without a header */
    TETRAKIS_HEIGHTS_HGT = 5,
    TETRAKIS_HEIGHTS_GDAL = 6
} tetrakis_height_format;
/* How samples without data are treated. */
typedef enum tetrakis_gaps {
    TETRAKIS_GAPS_REFUSED = 0, /* TETRAKIS_INVALID_INPUT */
    TETRAKIS_GAPS_FILLED = 1,  /* heights from the samples around; needs the whole file in memory */
    TETRAKIS_GAPS_LEVEL = 2    /* their height is gap_height */
} tetrakis_gaps;

/* How a file's heights are read. */
typedef struct tetrakis_height_options {
    size_t size;
    double spacing[2];      /* from column to column, from row to row; both 0: as the file says, or 1 */
    double scale, offset;   /* a height is offset + scale times the file's number */
    int format;             /* a tetrakis_height_format */
    uint32_t columns, rows; /* of raw files; both 0: square; one 0: computed from the file's size */
    int big_endian;         /* of raw files: high byte first */
    int has_no_data;        /* 1: no_data is used; HGT and GDAL's files have their own such number */
    double no_data;         /* the number in the file that means "no data" */
    int gaps;               /* a tetrakis_gaps */
    float gap_height;
} tetrakis_height_options;
#define TETRAKIS_HEIGHT_OPTIONS \
    { sizeof(tetrakis_height_options), {0, 0}, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0 }

/* Loads heights from a file into memory. x runs east, y north, z up. options: NULL is as TETRAKIS_HEIGHT_OPTIONS.
 * Any thread. Until tetrakis_free_surface(). */
TETRAKIS_API tetrakis_status tetrakis_load_terrain(const char* path, const tetrakis_height_options* options,
                                                   tetrakis_surface** surface);
/* heights: columns * rows numbers, row by row from the north, each row from the west. Sample (0, 0) is at x = y = 0.
 * Any thread. Until tetrakis_free_surface(). */
TETRAKIS_API tetrakis_status tetrakis_make_terrain(const float* heights, uint32_t columns, uint32_t rows,
                                                   double spacing, tetrakis_surface** surface);
/* Reads heights as tetrakis_load_terrain() does and writes a file of tiles. Raw files, HGT and GDAL's rasters are read
 * in parts, so they may be larger than memory. Any thread, but one at a time for the same tiles_path. */
TETRAKIS_API tetrakis_status tetrakis_write_tiles(const char* heights_path, const tetrakis_height_options* options,
                                                  const char* tiles_path);
/* Opens a file of tetrakis_write_tiles() as a surface. A thread of its own loads the tiles that views request; no other
 * call waits for it, and tiles in memory never take more than `cache_bytes`. The file must not change while the surface
 * lives. Any thread. Until tetrakis_free_surface(). */
TETRAKIS_API tetrakis_status tetrakis_open_tiles(const char* tiles_path, uint64_t cache_bytes,
                                                 tetrakis_surface** surface);
/* Heights over a ball about the origin, z to the north pole. Columns run eastwards from the antimeridian, rows
 * southwards from the north pole; samples are in the middles of equal cells of longitude and latitude.
 * level: finest triangles lie on 2^(level + 1) steps along a side of a cube's face; 0: as fine as the heights
 * Any thread. Until tetrakis_free_surface(). */
TETRAKIS_API tetrakis_status tetrakis_make_planet(const float* heights, uint32_t columns, uint32_t rows, double radius,
                                                  int level, tetrakis_surface** surface);
/* The same from six faces of a cube with side * side heights each, towards +x, -x, +y, -y, +z, -z, laid out as OpenGL's
 * cube maps. First and last rows and columns are on the cube's edges. Any thread. Until tetrakis_free_surface(). */
TETRAKIS_API tetrakis_status tetrakis_make_cube_planet(const float* const faces[6], uint32_t side, double radius,
                                                       int level, tetrakis_surface** surface);

/* Heights that are computed on demand. The functions receive `user` and return the same number each time for the same
 * arguments. Several threads may call them at once; they must not throw or longjmp. The functions and `user` must live
 * as long as the surfaces that are made of them. */
typedef struct tetrakis_procedural_heights {
    size_t size;
    double (*height)(void* user, const double place[3]); /* not below `low`, not above `high` */
    /* Bound on |height - linear interpolation from the corners| over any triangle in space that fits into a ball of
     * this radius. Must not fall as the radius grows. If it is too small, a view's pixel_error is wrong. */
    double (*deviation)(void* user, double radius);
    void* user;
    double slope; /* largest change of the height per length of way: a Lipschitz constant */
    double low, high;
} tetrakis_procedural_heights;
#define TETRAKIS_PROCEDURAL_HEIGHTS \
    { sizeof(tetrakis_procedural_heights), NULL, NULL, NULL, 0, 0, 0 }

/* Waves in random directions in 1 to 48 layers (`octaves`), each with half the wavelength and height of the one before.
 * `amplitude` and `wavelength` are of the first layer. Any thread. Until tetrakis_free_fractal_heights(). */
TETRAKIS_API tetrakis_status tetrakis_make_fractal_heights(double amplitude, double wavelength, int octaves,
                                                           uint64_t seed, tetrakis_procedural_heights* heights);
/* Frees heights of tetrakis_make_fractal_heights(), and no others. After all other calls, also with their surfaces. */
TETRAKIS_API void tetrakis_free_fractal_heights(tetrakis_procedural_heights* heights);
/* A square about the origin, heights along z at (x, y, 0). Triangles whose longest side is `finest` or less are not
 * split. No heights are stored. Any thread. Until tetrakis_free_surface(). */
TETRAKIS_API tetrakis_status tetrakis_make_procedural_plane(double side, double finest,
                                                            const tetrakis_procedural_heights* heights,
                                                            tetrakis_surface** surface);
/* A ball about the origin, heights outwards, at places on the ball. Any thread. Until tetrakis_free_surface(). */
TETRAKIS_API tetrakis_status tetrakis_make_procedural_ball(double radius, double finest,
                                                           const tetrakis_procedural_heights* heights,
                                                           tetrakis_surface** surface);
/* Limit surface of a scheme whose faces become quads, of doo-sabin, midedge or loop, in 2^(level + 1) steps along an
 * edge of `control` at most. `control` may be freed afterwards. Any thread. Until tetrakis_free_surface(). */
TETRAKIS_API tetrakis_status tetrakis_make_subdivision_surface(const tetrakis_control_mesh* control, const char* scheme,
                                                               int level, tetrakis_surface** surface);
/* After all other calls, also those with its views. */
TETRAKIS_API void tetrakis_free_surface(tetrakis_surface* surface);

/* Returns 1 and writes the full-resolution height and the upward unit normal of a terrain at (x, y). Returns 0 outside
 * the terrain, for other surfaces, and if the finest tile there is not loaded yet: the call requests it. Any thread. */
TETRAKIS_API int tetrakis_surface_at(const tetrakis_surface* surface, double x, double y, double* height,
                                     double normal[3]);
/* Returns 1 and writes where a ray first meets the full-resolution surface: origin + t * direction, t up to `farthest`.
 * Returns 0 if it does not. direction: length from 1e-100 to 1e100. normal: unit normal there, or NULL. Any thread. */
TETRAKIS_API int tetrakis_surface_hit(const tetrakis_surface* surface, const double origin[3],
                                      const double direction[3], double farthest, double* t, double normal[3]);

/* Returns 1 and writes the height of a planet's ground above its ball in a direction, and the outward unit normal.
 * Returns 0 for the direction (0, 0, 0) and for other surfaces. Any thread. */
TETRAKIS_API int tetrakis_planet_at(const tetrakis_surface* surface, const double direction[3], double* height,
                                    double normal[3]);
/* Grows whenever a tile has been loaded: an update of a view can then refine more. 0 without tiles. Any thread. */
TETRAKIS_API uint64_t tetrakis_surface_revision(const tetrakis_surface* surface);

typedef struct tetrakis_tile_statistics {
    size_t size;
    uint64_t loads, failures; /* of tiles so far; a tile that could not be read is tried again */
    uint64_t wanted;          /* tiles that are requested and not loaded yet */
    uint64_t cached_bytes;
    const char* last_error; /* "": no failure. Until this thread's next tetrakis_get_tile_statistics() */
} tetrakis_tile_statistics;
#define TETRAKIS_TILE_STATISTICS \
    { sizeof(tetrakis_tile_statistics), 0, 0, 0, 0, NULL }

/* Progress of loading; TETRAKIS_INVALID_INPUT for a surface without tiles. Any thread. */
TETRAKIS_API tetrakis_status tetrakis_get_tile_statistics(const tetrakis_surface* surface,
                                                          tetrakis_tile_statistics* statistics);

typedef struct tetrakis_view_options {
    size_t size;
    uint32_t max_leaves;   /* fixed capacity in triangles; at least the roots have room */
    uint64_t max_bytes;    /* capacity is lower if it would take more memory than this; 0: no limit */
    uint32_t max_ranges;   /* most ranges of one buffer in one update */
    double outside_weight; /* factor of errors outside the view: 0 to 1 */
    double hysteresis; /* triangles are merged if their error looks smaller than this part of the limit: 0.1 to 0.8 */
} tetrakis_view_options;
#define TETRAKIS_VIEW_OPTIONS \
    { sizeof(tetrakis_view_options), 200000, 0, 4096, 0.25, 0.8 }

/* Views of one surface are independent of each other. Any thread. Until tetrakis_free_view(). */
TETRAKIS_API tetrakis_status tetrakis_make_view(const tetrakis_surface* surface, const tetrakis_view_options* options,
                                                tetrakis_view** view);
/* After all other calls. */
TETRAKIS_API void tetrakis_free_view(tetrakis_view* view);

/* A ball in which errors are multiplied by `boost` >= 1, for example around a player, or where objects collide. */
typedef struct tetrakis_region {
    double center[3], radius, boost;
} tetrakis_region;
/* Replaces the regions of a view. The next update evaluates all triangles again. One thread a view. */
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
    double pixel_error;  /* triangles whose error looks larger than this many pixels are split */
    uint32_t leaves;     /* largest number of triangles */
    double milliseconds; /* an update ends soon after this, and the next update continues; 0: no limit. Triangles in
                            excess of `leaves` are merged first, however long that takes */
} tetrakis_budget;
#define TETRAKIS_BUDGET \
    { sizeof(tetrakis_budget), 1, UINT32_MAX, 0 }

/* A vertex to draw. With d its distance from the eye, a vertex shader places it at mix(position, on_edge, w), where
 *   w = clamp((d / (error * morph_scale) - 0.85) / 0.15, 0, 1). */
typedef struct tetrakis_vertex {
    float position[3]; /* relative to the view's origin */
    float on_edge[3];  /* on the edge that the vertex halves, in the same frame */
    int16_t normal[2]; /* octahedral, 32767 is 1 */
    float uv[2];
    float error;
} tetrakis_vertex;

typedef struct tetrakis_range {
    uint32_t first, count;
} tetrakis_range;

typedef struct tetrakis_update {
    size_t size;
    const tetrakis_range* vertex_ranges; /* changed parts of the two buffers, to be uploaded */
    const tetrakis_range* triangle_ranges;
    uint32_t vertex_range_count, triangle_range_count;
    uint32_t splits, merges, leaves;
    double pixel_error; /* in pixels: no error of a triangle that can be split looks larger; may be infinite */
    double morph_scale;
    int complete;     /* 1: the update was finished within its time */
    uint32_t waiting; /* diamonds (pairs of triangles) that are unchanged because their tile is not loaded yet */
} tetrakis_update;
#define TETRAKIS_UPDATE \
    { sizeof(tetrakis_update), NULL, NULL, 0, 0, 0, 0, 0, 0, 0, 0, 0 }

/* Adapts a view to the camera. The ranges belong to the view. One thread a view. Until its next tetrakis_update_view()
 * or tetrakis_free_view(). */
TETRAKIS_API tetrakis_status tetrakis_update_view(tetrakis_view* view, const tetrakis_camera* camera,
                                                  const tetrakis_budget* budget, tetrakis_update* update);

/* The vertex buffer, which belongs to the view. Its `count` never exceeds `capacity`, which is fixed. One thread a
 * view. Until the view's next tetrakis_update_view(), tetrakis_set_view_origin() or tetrakis_free_view(). */
TETRAKIS_API const tetrakis_vertex* tetrakis_view_vertices(const tetrakis_view* view, uint32_t* count,
                                                           uint32_t* capacity);
/* The triangle buffer: three vertex numbers for each triangle, all zero if it is unused. Do not draw triangles from
 * number `count` on. One thread a view. Until the same calls as of tetrakis_view_vertices(). */
TETRAKIS_API const uint32_t* tetrakis_view_triangles(const tetrakis_view* view, uint32_t* count, uint32_t* capacity);
typedef struct tetrakis_snapshot tetrakis_snapshot;
/* Copies the view's present triangles, without morphing, for queries by any thread. O(triangles log triangles).
 * One thread a view. Until tetrakis_free_snapshot(); the view may be freed before. */
TETRAKIS_API tetrakis_status tetrakis_take_snapshot(const tetrakis_view* view, tetrakis_snapshot** snapshot);
/* Writes a snapshot as a mesh (.obj, .ply or .glb) in the surface's own frame. Any thread. */
TETRAKIS_API tetrakis_status tetrakis_write_snapshot(const tetrakis_snapshot* snapshot, const char* path);
/* After all other calls. */
TETRAKIS_API void tetrakis_free_snapshot(tetrakis_snapshot* snapshot);
/* As tetrakis_surface_hit(), in the surface's own frame, but in single precision: a ray exactly through a vertex may
 * miss the mesh. Any thread. */
TETRAKIS_API int tetrakis_snapshot_hit(const tetrakis_snapshot* snapshot, const double origin[3],
                                       const double direction[3], double farthest, double* t, double normal[3]);
/* Positions become relative to `origin`: in a large world choose it near the eye. All change. One thread a view. */
TETRAKIS_API tetrakis_status tetrakis_set_view_origin(tetrakis_view* view, const double origin[3]);

#ifdef __cplusplus
}
#endif

#endif
