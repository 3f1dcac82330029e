#include "world/robot/model/arm_model.hpp"

#include <cmath>
#include <console_bridge/console.h>
#include <filesystem>
#include <map>
#include <mutex>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <urdf_parser/urdf_parser.h>

#include "world/robot/model/rotor_inertia.hpp"

namespace aprsim::robot {
namespace {

constexpr double kSameFrame = 1e-9;

Eigen::Vector3d vector(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

Eigen::Isometry3d transform(const urdf::Pose& pose) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  const urdf::Rotation& r = pose.rotation;
  X.linear() = Eigen::Quaterniond(r.w, r.x, r.y, r.z).normalized().toRotationMatrix();
  X.translation() = vector(pose.position);
  return X;
}

/// Within rounding of the file's numbers.
bool is_identity(const Eigen::Isometry3d& X) {
  return (X.matrix() - Eigen::Matrix4d::Identity()).cwiseAbs().maxCoeff() < kSameFrame;
}

/// Collects the URDF parser's messages for our own error message.
class ParserMessages final : public console_bridge::OutputHandler {
 public:
  ParserMessages() { console_bridge::useOutputHandler(this); }
  ~ParserMessages() override { console_bridge::restorePreviousOutputHandler(); }
  ParserMessages(const ParserMessages&) = delete;
  ParserMessages& operator=(const ParserMessages&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char* /*file*/,
           int /*line*/) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR) text_ += "; " + text;
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// Fills the model from the chain of a parsed URDF.
class ModelReader {
 public:
  ModelReader(std::string path, const urdf::ModelInterface& urdf,
              std::map<std::string, double> reflected)
      : path_(std::move(path)), urdf_(urdf), reflected_(std::move(reflected)) {}

  Result<ArmModel> read() {
    model_.name = urdf_.getName();
    const urdf::Link* link = urdf_.getRoot().get();
    model_.links.push_back({.name = link->name});
    // Dynamics needs rigid bodies joined by moving joints. Links behind fixed joints are merged
    // into the body before them.
    while (true) {
      if (auto added = add_body(*link); !added) return tl::unexpected(added.error());
      if (link->child_joints.empty()) break;
      if (link->child_joints.size() > 1) {
        return error(link->name, "link \"" + link->name + "\" carries " +
                                     std::to_string(link->child_joints.size()) +
                                     " joints; an arm is one chain");
      }
      const urdf::Joint& joint = *link->child_joints.front();
      if (auto added = add_joint(joint); !added) return tl::unexpected(added.error());
      link = link->child_links.front().get();
    }
    return finish();
  }

 private:
  [[nodiscard]] tl::unexpected<Error> error(const std::string& field,
                                            const std::string& text) const {
    return fail(ErrorCode::kInvalidArgument, field, path_ + ": " + text);
  }

  /// Adds a URDF link's mass and shapes to the last rigid body, at X_LC_.
  Result<void> add_body(const urdf::Link& source) {
    Link& body = model_.links.back();
    for (const auto& collision : source.collision_array) {
      auto shape = read_shape(source, *collision);
      if (!shape) return tl::unexpected(shape.error());
      body.collision.push_back(*shape);
    }
    for (const auto& visual : source.visual_array) add_visual(*visual, body);
    if (!source.inertial) return {};
    const urdf::Inertial& in = *source.inertial;
    const Eigen::Isometry3d X_LI = X_LC_ * transform(in.origin);
    Eigen::Matrix3d inertia;
    inertia << in.ixx, in.ixy, in.ixz, in.ixy, in.iyy, in.iyz, in.ixz, in.iyz, in.izz;
    if (!(in.mass > 0) || !plausible(inertia)) {
      return error(source.name, "link \"" + source.name +
                                    "\": <inertial> needs mass > 0 and a positive definite inertia "
                                    "whose principal moments obey a + b >= c");
    }
    combine(body, in.mass, X_LI.translation(), X_LI.linear() * inertia * X_LI.linear().transpose());
    return {};
  }

  /// Principal moments of a real body are positive and obey the triangle inequality; a part in
  /// 1e-3 is left for rounding in the file.
  static bool plausible(const Eigen::Matrix3d& inertia) {
    if (!inertia.allFinite()) return false;
    // I_1 + I_2 >= I_3: a violation means an inertia that no mass distribution has.
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia, Eigen::EigenvaluesOnly);
    const Eigen::Vector3d& m = solver.eigenvalues();
    return m(0) > 0 && m(0) + m(1) > m(2) * (1 - 1e-3);
  }

  /// Adds a mass to a body: parallel axis theorem for two bodies with the reduced mass.
  static void combine(Link& body, double mass, const Eigen::Vector3d& com,
                      const Eigen::Matrix3d& inertia) {
    const double total = body.mass_kg + mass;
    if (body.mass_kg == 0) {
      body.com_L = com;
      body.inertia_L = inertia;
    } else {
      const Eigen::Vector3d d = com - body.com_L;
      const double reduced = body.mass_kg * mass / total;
      // Parallel axes for both bodies at once, with the reduced mass.
      body.inertia_L +=
          inertia + reduced * (d.squaredNorm() * Eigen::Matrix3d::Identity() - d * d.transpose());
      body.com_L += d * (mass / total);
    }
    body.mass_kg = total;
  }

  /// Boxes, cylinders, spheres; URDF has no capsule, so a cylinder's name says it is one.
  Result<LinkShape> read_shape(const urdf::Link& link, const urdf::Collision& collision) {
    LinkShape out;
    // URDF poses are relative to the URDF link; here they become relative to the rigid body.
    out.X_LS = X_LC_ * transform(collision.origin);
    const std::string& name = collision.name;
    const bool capsule = name.ends_with("_capsule");
    const urdf::Geometry& geometry = *collision.geometry;
    if (const auto* box = dynamic_cast<const urdf::Box*>(&geometry)) {
      out.shape = BoxShape{vector(box->dim)};
    } else if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(&geometry)) {
      if (capsule) {
        out.shape = CapsuleShape{cylinder->radius, cylinder->length};
      } else {
        out.shape = CylinderShape{cylinder->radius, cylinder->length};
      }
    } else if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(&geometry)) {
      out.shape = SphereShape{sphere->radius};
    } else {
      return error(link.name, "link \"" + link.name + "\": collision \"" + name +
                                  "\" must be a box, cylinder or sphere");
    }
    return out;
  }

  /// Shapes of mesh files are skipped: nothing depends on looks.
  void add_visual(const urdf::Visual& visual, Link& body) const {
    LinkVisual out;
    out.shape.X_LS = X_LC_ * transform(visual.origin);
    const urdf::Geometry& geometry = *visual.geometry;
    if (const auto* box = dynamic_cast<const urdf::Box*>(&geometry)) {
      out.shape.shape = BoxShape{vector(box->dim)};
    } else if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(&geometry)) {
      out.shape.shape = CylinderShape{cylinder->radius, cylinder->length};
    } else if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(&geometry)) {
      out.shape.shape = SphereShape{sphere->radius};
    } else {
      return;
    }
    if (visual.material) {
      const urdf::Color& colour = visual.material->color;
      out.colour << colour.r, colour.g, colour.b;
    }
    body.visual.push_back(out);
  }

  /// A moving joint starts the next rigid body; a fixed one only moves the frame to read in.
  Result<void> add_joint(const urdf::Joint& source) {
    const Eigen::Isometry3d X_CJ = transform(source.parent_to_joint_origin_transform);
    if (source.type == urdf::Joint::FIXED) {
      X_LC_ = X_LC_ * X_CJ;
      return {};
    }
    const bool continuous = source.type == urdf::Joint::CONTINUOUS;
    const bool prismatic = source.type == urdf::Joint::PRISMATIC;
    if (source.type != urdf::Joint::REVOLUTE && !continuous && !prismatic) {
      return error(source.name, "joint \"" + source.name +
                                    "\" must be revolute, continuous, prismatic or fixed");
    }
    if (model_.dof() == kMaxDof) {
      return error(source.name, "joint \"" + source.name +
                                    "\" is one too many: an arm has at most " +
                                    std::to_string(kMaxDof) + " moving joints");
    }
    Joint joint{.name = source.name,
                .prismatic = prismatic,
                .X_PJ = X_LC_ * X_CJ,
                .axis = vector(source.axis)};
    if (std::abs(joint.axis.norm() - 1) > 1e-6) {
      return error(source.name, "joint \"" + source.name + "\": <axis> must have length 1");
    }
    joint.axis.normalize();
    if (auto read = read_limits(source, continuous, joint); !read) return read;
    // Names that remain in the map are no joint of the arm.
    // Rotor inertia is added to the joint's axis only (Siciliano et al. 2009, sec. 7.1.1, without
    // gyroscopic terms).
    if (const auto found = reflected_.find(source.name); found != reflected_.end()) {
      joint.rotor_inertia_kg_m2 = found->second;
      reflected_.erase(found);
    }
    // Joint i moves link i + 1; all later fixed links belong to that link.
    model_.joints.push_back(joint);
    model_.links.push_back({.name = source.child_link_name});
    X_LC_ = Eigen::Isometry3d::Identity();
    return {};
  }

  /// The parser demands <limit> of revolute and prismatic joints, but not of continuous ones.
  Result<void> read_limits(const urdf::Joint& source, bool continuous, Joint& joint) const {
    if (!source.limits) {
      return error(source.name,
                   "joint \"" + source.name + "\": <limit> with velocity and effort is missing");
    }
    const urdf::JointLimits& limits = *source.limits;
    const bool ordered = continuous || limits.lower < limits.upper;
    if (!ordered || !(limits.velocity > 0) || !(limits.effort > 0)) {
      return error(source.name, "joint \"" + source.name +
                                    "\": <limit> needs lower < upper, velocity > 0, effort > 0");
    }
    constexpr double kFullTurn = 2 * std::numbers::pi;
    joint.lower_rad = continuous ? -kFullTurn : limits.lower;
    joint.upper_rad = continuous ? kFullTurn : limits.upper;
    joint.max_speed_rad_s = limits.velocity;
    joint.max_torque_nm = limits.effort;
    return {};
  }

  /// Checks that need the whole chain.
  Result<ArmModel> finish() {
    if (model_.joints.empty()) return error("robot", "the arm has no moving joint");
    if (model_.dof() < kMinDof) {
      return error("robot", "the arm has " + std::to_string(model_.dof()) +
                                " moving joints, expected " + std::to_string(kMinDof) + " to " +
                                std::to_string(kMaxDof));
    }
    if (!is_identity(X_LC_)) move_to_flange(model_.links.back());
    for (const Link& link : model_.links) {
      if (link.mass_kg == 0) {
        return error(link.name,
                     "link \"" + link.name + "\" has no <inertial>, which the arm's dynamics need");
      }
    }
    if (!reflected_.empty()) {
      return error(reflected_.begin()->first, "<transmission> names joint \"" +
                                                  reflected_.begin()->first +
                                                  "\", which is not a moving joint of the arm");
    }
    return std::move(model_);
  }

  /// Expresses the last body in the frame of the chain's last link, the flange.
  void move_to_flange(Link& body) {
    model_.X_LF = X_LC_;
    const Eigen::Isometry3d X_FL = X_LC_.inverse();
    body.com_L = X_FL * body.com_L;
    body.inertia_L = X_FL.linear() * body.inertia_L * X_FL.linear().transpose();
    for (LinkShape& shape : body.collision) shape.X_LS = X_FL * shape.X_LS;
    for (LinkVisual& visual : body.visual) visual.shape.X_LS = X_FL * visual.shape.X_LS;
  }

  std::string path_;
  const urdf::ModelInterface& urdf_;
  std::map<std::string, double> reflected_;
  ArmModel model_;
  /// The URDF link being read in the last rigid body: fixed joints are merged into their parent.
  Eigen::Isometry3d X_LC_ = Eigen::Isometry3d::Identity();
};

}  // namespace

Result<ArmModel> load_arm_model(const std::string& urdf_path) {
  if (!std::filesystem::is_regular_file(urdf_path)) {
    return fail(ErrorCode::kNotFound, "urdf", urdf_path + ": no such file");
  }
  auto reflected = read_reflected_inertias(urdf_path);
  if (!reflected) return tl::unexpected(reflected.error());
  // The output of urdfdom is the process's: one at a time.
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  // urdfdom writes errors to the console; they belong into the error message instead.
  const ParserMessages messages;
  const urdf::ModelInterfaceSharedPtr urdf = urdf::parseURDFFile(urdf_path);
  if (!urdf) {
    return fail(ErrorCode::kInvalidArgument, "urdf",
                urdf_path + ": not a valid URDF robot description" + messages.text());
  }
  return ModelReader(urdf_path, *urdf, std::move(*reflected)).read();
}

}  // namespace aprsim::robot
