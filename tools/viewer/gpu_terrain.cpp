#include "gpu_terrain.hpp"

#include "../../eval/render/render.hpp"
#include "../../hier/base/error.hpp"
#include "shaders.hpp"

#include <epoxy/gl.h>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>

#include <array>
#include <cstddef>
#include <string>

namespace tetrakis::viewer {
namespace {

unsigned made_program(const std::string& vertex, const std::string& fragment) {
    const unsigned program = glCreateProgram();
    std::array<char, 1000> log{};
    const auto add = [&](GLenum kind, const std::string& text) {
        const unsigned shader = glCreateShader(kind);
        const char* source = text.c_str();
        glShaderSource(shader, 1, &source, nullptr);
        glCompileShader(shader);
        int done = 0;
        glGetShaderiv(shader, GL_COMPILE_STATUS, &done);
        if (done == 0) glGetShaderInfoLog(shader, log.size(), nullptr, log.data());
        glAttachShader(program, shader);
        glDeleteShader(shader);  // takes effect when the program is deleted
    };
    add(GL_VERTEX_SHADER, vertex);
    add(GL_FRAGMENT_SHADER, fragment);
    glLinkProgram(program);
    int done = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &done);
    if (done == 0 && log[0] == 0) glGetProgramInfoLog(program, log.size(), nullptr, log.data());
    if (done == 0) throw Error(ErrorCode::unsupported, fmt::format("OpenGL does not take the shaders: {}", log.data()));
    return program;
}

/// Makes a program current and sets its uniforms.
class Uniforms {
  public:
    explicit Uniforms(unsigned program) : program_(program) { glUseProgram(program); }
    void set(const char* name, double value) const { glUniform1f(at(name), static_cast<float>(value)); }
    void set(const char* name, bool value) const { glUniform1i(at(name), value ? 1 : 0); }
    void set(const char* name, const Vec3f& value) const { glUniform3fv(at(name), 1, glm::value_ptr(value)); }
    void set(const char* name, const glm::mat4& value) const {
        glUniformMatrix4fv(at(name), 1, GL_FALSE, glm::value_ptr(value));
    }

  private:
    int at(const char* name) const { return glGetUniformLocation(program_, name); }
    unsigned program_;
};

template <class T>
std::uint64_t copy(GLenum target, std::span<const T> from, std::span<const lod::Update::Range> ranges) {
    std::uint64_t bytes = 0;
    for (const auto [first, count] : ranges) {
        const std::span<const T> changed = from.subspan(first, count);
        glBufferSubData(target, static_cast<GLintptr>(first * sizeof(T)), static_cast<GLsizeiptr>(changed.size_bytes()),
                        changed.data());
        bytes += changed.size_bytes();
    }
    return bytes;
}

}  // namespace

Lights lights_of(const lod::Camera& camera) {
    const Vec3d right = unit_or_zero(glm::cross(camera.direction, camera.up)), back = glm::cross(right, camera.up);
    return {.key = glm::normalize(-0.75 * right + 0.65 * back + 1.15 * camera.up),
            .fill = glm::normalize(right + 0.55 * back + 0.15 * camera.up),
            .rim = glm::normalize(0.55 * right - back + 0.55 * camera.up)};
}

GpuTerrain::GpuTerrain(const lod::View& view) : view_(view) {
    ground_ = made_program(k_ground_vertex, std::string(k_colour_functions) + k_ground_fragment);
    sky_ = made_program(k_sky_vertex, std::string(k_colour_functions) + k_sky_fragment);
    glGenVertexArrays(1, &no_arrays_);
    glGenVertexArrays(1, &arrays_);
    glBindVertexArray(arrays_);
    const auto buffer = [](GLenum target, std::size_t bytes) {
        unsigned name = 0;
        glGenBuffers(1, &name);
        glBindBuffer(target, name);
        glBufferData(target, static_cast<GLsizeiptr>(bytes), nullptr, GL_DYNAMIC_DRAW);
        return name;
    };
    vertices_ = buffer(GL_ARRAY_BUFFER, view.vertex_capacity() * sizeof(lod::Vertex));
    triangles_ = buffer(GL_ELEMENT_ARRAY_BUFFER, view.triangle_capacity() * sizeof(lod::Triangle));
    const auto attribute = [](unsigned location, int count, GLenum type, std::size_t offset) {
        glEnableVertexAttribArray(location);
        glVertexAttribPointer(location, count, type, GL_FALSE, sizeof(lod::Vertex),
                              reinterpret_cast<const void*>(offset));
    };
    attribute(0, 3, GL_FLOAT, offsetof(lod::Vertex, position));
    attribute(1, 3, GL_FLOAT, offsetof(lod::Vertex, on_edge));
    attribute(2, 2, GL_SHORT, offsetof(lod::Vertex, normal));
    attribute(3, 1, GL_FLOAT, offsetof(lod::Vertex, error));
}

GpuTerrain::~GpuTerrain() {
    for (const unsigned name : {vertices_, triangles_}) glDeleteBuffers(1, &name);
    for (const unsigned name : {arrays_, no_arrays_}) glDeleteVertexArrays(1, &name);
    for (const unsigned name : {ground_, sky_}) glDeleteProgram(name);
}

std::uint64_t GpuTerrain::upload(const lod::Update& update, const Vec3d& eye) {
    morph_eye_ = eye;
    morph_scale_ = update.morph_scale;
    glBindVertexArray(arrays_);
    glBindBuffer(GL_ARRAY_BUFFER, vertices_);
    return copy(GL_ARRAY_BUFFER, view_.vertices(), update.vertices) +
           copy(GL_ELEMENT_ARRAY_BUFFER, view_.triangles(), update.triangles);
}

void GpuTerrain::draw(const Look& look) const {
    const RenderOptions colours;
    const lod::Camera& camera = look.camera;
    glViewport(0, 0, static_cast<int>(camera.width), static_cast<int>(camera.height));
    glClear(GL_DEPTH_BUFFER_BIT);

    glDisable(GL_DEPTH_TEST);
    glDisable(GL_CULL_FACE);
    glBindVertexArray(no_arrays_);
    const Uniforms sky(sky_);
    sky.set("top_colour", colours.background_top);
    sky.set("bottom_colour", colours.background_bottom);
    glDrawArrays(GL_TRIANGLES, 0, 3);

    glEnable(GL_DEPTH_TEST);
    glEnable(GL_CULL_FACE);  // otherwise back faces show along ridges, where depths are equal
    glBindVertexArray(arrays_);
    const Uniforms ground(ground_);
    const double aspect = static_cast<double>(camera.width) / camera.height;
    ground.set("projection", glm::mat4(glm::perspective(camera.vertical_fov, aspect, look.nearest, look.farthest) *
                                       glm::lookAt(Vec3d(0), camera.direction, camera.up)));
    ground.set("eye", Vec3f(camera.eye - view_.origin()));
    ground.set("morph_eye", Vec3f(morph_eye_ - view_.origin()));
    ground.set("morph_scale", morph_scale_);
    ground.set("morph_begin", lod::k_morph_begin);
    ground.set("key", Vec3f(look.lights.key));
    ground.set("fill", Vec3f(look.lights.fill));
    ground.set("rim", Vec3f(look.lights.rim));
    ground.set("up", Vec3f(camera.up));
    ground.set("surface_colour", colours.surface_colour);
    ground.set("wire_colour", colours.wire_colour);
    ground.set("wire", false);
    const auto indices = static_cast<int>(3 * view_.triangles().size());
    glDrawElements(GL_TRIANGLES, indices, GL_UNSIGNED_INT, nullptr);
    if (!look.wireframe) return;
    ground.set("wire", true);
    glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
    glEnable(GL_POLYGON_OFFSET_LINE);
    glPolygonOffset(-1, -1);
    glDrawElements(GL_TRIANGLES, indices, GL_UNSIGNED_INT, nullptr);
    glDisable(GL_POLYGON_OFFSET_LINE);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
}

}  // namespace tetrakis::viewer
