#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/trace/exports.hpp"
#include "clients/aprsim/trace/listing.hpp"
#include "clients/aprsim/trace/mcap_writer.hpp"
#include "clients/aprsim/trace/motion_reader.hpp"
#include "clients/aprsim/trace/trace.hpp"

namespace aprsim::trace {
namespace {

using Json = nlohmann::ordered_json;
using client::failed;
using client::FailureKind;

constexpr const char* kWorld = "world";

// ---- Schemas: names and fields of Foxglove (docs.foxglove.dev/docs/sdk/schemas).

Json object_schema(const std::vector<std::pair<std::string, Json>>& properties) {
  Json out{{"type", "object"}, {"properties", Json::object()}};
  for (const auto& [name, schema] : properties) out["properties"][name] = schema;
  return out;
}
Json array_schema(const Json& items) { return {{"type", "array"}, {"items", items}}; }
const Json& number_schema() {
  static const Json kNumber{{"type", "number"}};
  return kNumber;
}
const Json& text_schema() {
  static const Json kText{{"type", "string"}};
  return kText;
}
Json whole_schema() { return {{"type", "integer"}}; }
Json numbers_schema(const std::vector<std::string>& names) {
  std::vector<std::pair<std::string, Json>> properties;
  for (const std::string& name : names) properties.emplace_back(name, number_schema());
  return object_schema(properties);
}
Json time_schema() { return object_schema({{"sec", whole_schema()}, {"nsec", whole_schema()}}); }
Json vector_schema() { return numbers_schema({"x", "y", "z"}); }
Json turn_schema() { return numbers_schema({"x", "y", "z", "w"}); }
Json pose_schema() {
  return object_schema({{"position", vector_schema()}, {"orientation", turn_schema()}});
}
Json color_schema() { return numbers_schema({"r", "g", "b", "a"}); }

std::string titled(const std::string& title, Json schema) {
  schema["title"] = title;
  return schema.dump();
}

std::string transforms_schema() {
  const Json transform = object_schema({{"timestamp", time_schema()},
                                        {"parent_frame_id", text_schema()},
                                        {"child_frame_id", text_schema()},
                                        {"translation", vector_schema()},
                                        {"rotation", turn_schema()}});
  return titled("foxglove.FrameTransforms",
                object_schema({{"transforms", array_schema(transform)}}));
}

std::string scene_schema() {
  const Json cube = object_schema(
      {{"pose", pose_schema()}, {"size", vector_schema()}, {"color", color_schema()}});
  const Json cylinder = object_schema({{"pose", pose_schema()},
                                       {"size", vector_schema()},
                                       {"bottom_scale", number_schema()},
                                       {"top_scale", number_schema()},
                                       {"color", color_schema()}});
  const Json triangles = object_schema({{"pose", pose_schema()},
                                        {"points", array_schema(vector_schema())},
                                        {"color", color_schema()},
                                        {"colors", array_schema(color_schema())},
                                        {"indices", array_schema(whole_schema())}});
  const Json pair = object_schema({{"key", text_schema()}, {"value", text_schema()}});
  Json entity = object_schema({{"timestamp", time_schema()},
                               {"frame_id", text_schema()},
                               {"id", text_schema()},
                               {"lifetime", time_schema()},
                               {"frame_locked", {{"type", "boolean"}}},
                               {"metadata", array_schema(pair)},
                               {"cubes", array_schema(cube)},
                               {"cylinders", array_schema(cylinder)},
                               {"triangles", array_schema(triangles)}});
  for (const char* name : {"arrows", "spheres", "lines", "texts", "models"}) {
    entity["properties"][name] = array_schema({{"type", "object"}});
  }
  return titled("foxglove.SceneUpdate",
                object_schema({{"deletions", array_schema({{"type", "object"}})},
                               {"entities", array_schema(entity)}}));
}

std::string log_schema() {
  return titled("foxglove.Log", object_schema({{"timestamp", time_schema()},
                                               {"level", whole_schema()},
                                               {"message", text_schema()},
                                               {"name", text_schema()},
                                               {"file", text_schema()},
                                               {"line", whole_schema()}}));
}

std::string joints_schema() {
  const Json joint = numbers_schema({"position_rad", "velocity_rad_s", "torque_nm"});
  return titled(
      "aprsim.Joints",
      object_schema(
          {{"time_s", number_schema()},
           {"robots", array_schema(object_schema({{"name", text_schema()},
                                                  {"gripper_separation_m", number_schema()},
                                                  {"holding", {{"type", "boolean"}}},
                                                  {"joints", array_schema(joint)}}))}}));
}

std::string belt_schema() {
  Json schema = numbers_schema({"time_s", "speed_m_s", "travel_m", "load_kg"});
  schema["properties"]["run"] = {{"type", "boolean"}};
  return titled("aprsim.Belt", schema);
}

std::string line_schema(const std::string& title) {
  return titled(title, object_schema({{"time_s", number_schema()},
                                      {"wire", text_schema()},
                                      {"connection", whole_schema()},
                                      {"direction", text_schema()},
                                      {"text", text_schema()}}));
}

// ---- Messages.

std::uint64_t nanoseconds(double time_s) {
  return static_cast<std::uint64_t>(std::llround(std::max(0.0, time_s) * 1e9));
}
Json time_json(double time_s) {
  const std::uint64_t ns = nanoseconds(time_s);
  return {{"sec", ns / 1'000'000'000}, {"nsec", ns % 1'000'000'000}};
}
Json vector_json(double x, double y, double z) { return {{"x", x}, {"y", y}, {"z", z}}; }
Json vector_json(const v1::Vector3& v) { return vector_json(v.x(), v.y(), v.z()); }
Json turn_json(const v1::Quaternion& q) {
  return {{"x", q.x()}, {"y", q.y()}, {"z", q.z()}, {"w", q.w()}};
}
Json pose_json(const v1::Pose& pose) {
  return {{"position", vector_json(pose.position_m())},
          {"orientation", turn_json(pose.orientation())}};
}
/// Along the axes of its frame.
Json pose_at(double x, double y, double z) {
  return {{"position", vector_json(x, y, z)},
          {"orientation", {{"x", 0}, {"y", 0}, {"z", 0}, {"w", 1}}}};
}
Json color_json(double r, double g, double b) { return {{"r", r}, {"g", g}, {"b", b}, {"a", 1}}; }

Json transform_json(double time_s, const std::string& parent, const std::string& child,
                    const v1::Pose& pose) {
  return {{"timestamp", time_json(time_s)},
          {"parent_frame_id", parent},
          {"child_frame_id", child},
          {"translation", vector_json(pose.position_m())},
          {"rotation", turn_json(pose.orientation())}};
}

Json transforms_json(double time_s, const v1::Snapshot& snapshot, const v1::CellDescription* cell) {
  Json all = Json::array();
  for (const auto& body : snapshot.bodies()) {
    all.push_back(transform_json(time_s, kWorld, body.name(), body.body_in_world()));
  }
  for (const auto& robot : snapshot.robots()) {
    all.push_back(transform_json(time_s, kWorld, robot.name() + "/tool", robot.tool_in_world()));
  }
  if (cell != nullptr) {
    for (const auto& robot : cell->robots()) {
      all.push_back(transform_json(time_s, kWorld, robot.name() + "/base", robot.base_in_world()));
    }
    for (const auto& fixture : cell->fixtures()) {
      all.push_back(transform_json(time_s, kWorld, fixture.name(), fixture.fixture_in_world()));
    }
  }
  return {{"transforms", all}};
}

Json entity_json(const std::string& frame, const std::string& id) {
  Json out{{"timestamp", time_json(0)},
           {"frame_id", frame},
           {"id", id},
           {"lifetime", time_json(0)},
           {"frame_locked", true}};
  for (const char* name : {"metadata", "arrows", "cubes", "spheres", "cylinders", "lines",
                           "triangles", "texts", "models"}) {
    out[name] = Json::array();
  }
  return out;
}

Json cylinder_json(double bottom, double top, double radius, const Json& color) {
  return {{"pose", pose_at(0, 0, (bottom + top) / 2)},
          {"size", vector_json(2 * radius, 2 * radius, top - bottom)},
          {"bottom_scale", 1},
          {"top_scale", 1},
          {"color", color}};
}

/// A tray's slab with an outline as triangles, seen from outside counter-clockwise: points in
/// pairs, of the underside and of the top face.
Json prism_json(const v1::TrayGeometry& tray, const Json& color) {
  Json points = Json::array(), indices = Json::array();
  for (const auto& corner : tray.outline_m()) {
    points.push_back(vector_json(corner.x(), corner.y(), tray.box_min_m().z()));
    points.push_back(vector_json(corner.x(), corner.y(), tray.box_max_m().z()));
  }
  const auto add = [&indices](int a, int b, int c) {
    for (const int i : {a, b, c}) indices.push_back(i);
  };
  const int count = tray.outline_m_size();
  for (int i = 0; i < count; ++i) {
    const int low = 2 * i, next = 2 * ((i + 1) % count);
    add(low, next, next + 1);
    add(low, next + 1, low + 1);
    if (i == 0 || i == count - 1) continue;
    add(1, low + 1, next + 1);
    add(0, next, low);
  }
  return {{"pose", pose_at(0, 0, 0)},
          {"points", points},
          {"color", color},
          {"colors", Json::array()},
          {"indices", indices}};
}

Json slab_json(const v1::TrayGeometry& tray, const Json& color) {
  const auto &low = tray.box_min_m(), &high = tray.box_max_m();
  return {{"pose",
           pose_at((low.x() + high.x()) / 2, (low.y() + high.y()) / 2, (low.z() + high.z()) / 2)},
          {"size", vector_json(high.x() - low.x(), high.y() - low.y(), high.z() - low.z())},
          {"color", color}};
}

/// A pose in another one, about whose z it is centred.
Json ball_json(const v1::Pose& pose, const Json& offset_position, double radius,
               const Json& color) {
  return {{"pose", {{"position", offset_position}, {"orientation", turn_json(pose.orientation())}}},
          {"size", vector_json(2 * radius, 2 * radius, 2 * radius)},
          {"color", color}};
}

/// Point at height z of a frame.
Json point_on_axis(const v1::Pose& pose, double z) {
  const auto& q = pose.orientation();
  const Eigen::Vector3d p =
      Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()) * Eigen::Vector3d(0, 0, z);
  const auto& at = pose.position_m();
  return vector_json(at.x() + p.x(), at.y() + p.y(), at.z() + p.z());
}

/// A prism or polyhedron as the box around it.
Json around_json(const v1::Pose& pose,
                 const google::protobuf::RepeatedPtrField<v1::Vector3>& corners, double height_m,
                 const Json& color) {
  Eigen::AlignedBox3d box;
  for (const auto& corner : corners)
    box.extend(Eigen::Vector3d(corner.x(), corner.y(), corner.z()));
  const auto& q = pose.orientation();
  const Eigen::Vector3d c =
      Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()) * box.center() +
      Eigen::Vector3d(pose.position_m().x(), pose.position_m().y(), pose.position_m().z());
  const Eigen::Vector3d size = box.sizes();
  return {{"pose",
           {{"position", vector_json(c.x(), c.y(), c.z())},
            {"orientation", turn_json(pose.orientation())}}},
          {"size", vector_json(size.x(), size.y(), size.z() + height_m)},
          {"color", color}};
}

/// A piece of a part or fixture; prisms and polyhedra as the boxes around them.
void add_piece(const v1::Piece& piece, const Json& color, Json& entity) {
  const v1::Pose& pose = piece.piece_in_body();
  if (piece.has_box()) {
    entity["cubes"].push_back(
        {{"pose", pose_json(pose)}, {"size", vector_json(piece.box().size_m())}, {"color", color}});
  } else if (piece.has_cone()) {
    const auto& cone = piece.cone();
    const double widest = std::max(cone.bottom_radius_m(), cone.top_radius_m());
    entity["cylinders"].push_back({{"pose", pose_json(pose)},
                                   {"size", vector_json(2 * widest, 2 * widest, cone.height_m())},
                                   {"bottom_scale", cone.bottom_radius_m() / widest},
                                   {"top_scale", cone.top_radius_m() / widest},
                                   {"color", color}});
  } else if (piece.has_capsule()) {
    const auto& capsule = piece.capsule();
    const double r = capsule.radius_m(), half = capsule.length_m() / 2;
    entity["spheres"].push_back(ball_json(pose, point_on_axis(pose, -half), r, color));
    if (half == 0) return;
    entity["spheres"].push_back(ball_json(pose, point_on_axis(pose, half), r, color));
    entity["cylinders"].push_back({{"pose", pose_json(pose)},
                                   {"size", vector_json(2 * r, 2 * r, 2 * half)},
                                   {"bottom_scale", 1},
                                   {"top_scale", 1},
                                   {"color", color}});
  } else if (piece.has_prism()) {
    entity["cubes"].push_back(
        around_json(pose, piece.prism().corners_m(), piece.prism().height_m(), color));
  } else {
    entity["cubes"].push_back(around_json(pose, piece.hull().corners_m(), 0, color));
  }
}

/// The entities of the scene: boxes, fixtures and bodies, each fixed to its frame.
Json scene_json(const v1::MotionHeader& header, double time_s) {
  Json entities = Json::array();
  for (const auto& box : header.appearance().fixed()) {
    Json entity = entity_json(kWorld, box.name());
    entity["cubes"].push_back({{"pose", pose_json(box.box_in_world())},
                               {"size", vector_json(box.size_m())},
                               {"color", color_json(0.55, 0.55, 0.58)}});
    entities.push_back(entity);
  }
  for (const auto& fixture : header.cell().fixtures()) {
    Json entity = entity_json(fixture.name(), fixture.name());
    for (const auto& piece : fixture.pieces()) {
      add_piece(piece, color_json(0.5, 0.53, 0.58), entity);
    }
    entities.push_back(entity);
  }
  for (const auto& body : header.cell().bodies()) {
    Json entity = entity_json(body.name(), body.name());
    entity["metadata"].push_back({{"key", "type"}, {"value", body.type()}});
    if (body.has_gear()) {
      const auto& gear = body.gear();
      const Json color = color_json(0.8, 0.6, 0.2);
      entity["cylinders"].push_back(
          cylinder_json(0, gear.disc_height_m(), gear.disc_radius_m(), color));
      entity["cylinders"].push_back(
          cylinder_json(gear.disc_height_m(), gear.peg_top_m(), gear.peg_radius_m(), color));
    } else if (body.has_part()) {
      for (const auto& piece : body.part().pieces()) {
        add_piece(piece, color_json(0.3, 0.5, 0.8), entity);
      }
    } else {
      const Json color = color_json(0.25, 0.35, 0.5);
      if (body.tray().outline_m().empty()) {
        entity["cubes"].push_back(slab_json(body.tray(), color));
      } else {
        entity["triangles"].push_back(prism_json(body.tray(), color));
      }
    }
    entities.push_back(entity);
  }
  // Removes the entities of the previous scene.
  constexpr int kAll = 1;
  const Json all = {{"timestamp", time_json(time_s)}, {"type", kAll}, {"id", ""}};
  return {{"deletions", Json::array({all})}, {"entities", entities}};
}

Json joints_json(double time_s, const v1::Snapshot& snapshot) {
  Json robots = Json::array();
  for (const auto& robot : snapshot.robots()) {
    Json joints = Json::array();
    for (const auto& joint : robot.joints()) {
      joints.push_back({{"position_rad", joint.position_rad()},
                        {"velocity_rad_s", joint.velocity_rad_s()},
                        {"torque_nm", joint.torque_nm()}});
    }
    robots.push_back({{"name", robot.name()},
                      {"gripper_separation_m", robot.gripper().separation_m()},
                      {"holding", robot.gripper().holding()},
                      {"joints", joints}});
  }
  return {{"time_s", time_s}, {"robots", robots}};
}

Json belt_json(double time_s, const v1::ConveyorState& belt) {
  return {{"time_s", time_s},
          {"speed_m_s", belt.speed_m_s()},
          {"travel_m", belt.travel_m()},
          {"load_kg", belt.load_kg()},
          {"run", belt.run()}};
}

/// Escapes bytes that are not UTF-8.
std::string dumped(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// Collects the messages of one file.
class Export {
 public:
  explicit Export(const std::string& file)
      : out_(file),
        transforms_(out_.add_channel("/tf", "foxglove.FrameTransforms", transforms_schema())),
        scene_(out_.add_channel("/scene", "foxglove.SceneUpdate", scene_schema())),
        log_(out_.add_channel("/log", "foxglove.Log", log_schema())),
        joints_(out_.add_channel("/joints", "aprsim.Joints", joints_schema())),
        belt_(out_.add_channel("/belt", "aprsim.Belt", belt_schema())),
        events_(out_.add_channel("/events", "aprsim.Event", line_schema("aprsim.Event"))),
        wires_(out_.add_channel("/wires", "aprsim.Wire", line_schema("aprsim.Wire"))) {}

  client::Outcome<void> motion(const std::string& file, Exported& counts) {
    const auto read = read_motion(file, [&](double time_s, const v1::Snapshot& snapshot,
                                            const v1::MotionHeader* scene) {
      const std::uint64_t now = nanoseconds(time_s);
      // A scene precedes the motion in it.
      if (scene != nullptr) out_.add(scene_, now, dumped(scene_json(*scene, time_s)));
      out_.add(
          transforms_, now,
          dumped(transforms_json(time_s, snapshot, scene != nullptr ? &scene->cell() : nullptr)));
      out_.add(joints_, now, dumped(joints_json(time_s, snapshot)));
      if (snapshot.has_conveyor()) {
        out_.add(belt_, now, dumped(belt_json(time_s, snapshot.conveyor())));
      }
      ++counts.snapshots;
    });
    if (!read) return failed(FailureKind::kUsage, read.error().message);
    return {};
  }

  void line(const ListedLine& line, Exported& counts) {
    const bool event = line.wire == "cell";
    out_.add(event ? events_ : wires_, nanoseconds(line.time_s), dumped(json_of(line)));
    ++(event ? counts.events : counts.wires);
    if (!event) return;
    constexpr int kInfo = 2;
    out_.add(log_, nanoseconds(line.time_s),
             dumped({{"timestamp", time_json(line.time_s)},
                     {"level", kInfo},
                     {"message", line.text},
                     {"name", "cell"},
                     {"file", ""},
                     {"line", 0}}));
  }

  client::Outcome<void> finish(Exported& counts) {
    counts.messages = out_.messages();
    if (auto done = out_.finish(); !done) return failed(FailureKind::kUsage, done.error().message);
    return {};
  }

 private:
  McapWriter out_;
  std::uint16_t transforms_, scene_, log_, joints_, belt_, events_, wires_;
};

}  // namespace

client::Outcome<Exported> export_mcap(const std::string& place, const std::string& motion,
                                      const std::string& file) {
  Exported counts;
  Export out(file);
  if (!motion.empty()) {
    if (auto done = out.motion(motion, counts); !done) return tl::unexpected(done.error());
  }
  const auto listed =
      list_trace(place, {.polls = true}, [&](const ListedLine& line) { out.line(line, counts); });
  if (!listed) return failed(FailureKind::kUsage, listed.error().message);
  if (auto done = out.finish(counts); !done) return tl::unexpected(done.error());
  return counts;
}

}  // namespace aprsim::trace
