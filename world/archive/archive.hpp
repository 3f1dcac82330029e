#pragma once

#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <typeinfo>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Geometry>

#include "world/archive/layout.hpp"
#include "world/archive/world_counts.hpp"
#include "world/base/fields.hpp"

/// Values as bytes and back, bit for bit: the format of saved states. A type lists its members in
/// one function for both directions, by a structured binding of all of them, so that a new member
/// without a decision does not compile:
///
///     template <typename Self, typename Io>
///     static void fields(Self& self, Io& io) {
///       auto& [position, speed, limits] = self;
///       io(position, speed);  // the limits are the scene's
///     }
///
/// or it has a list of fields (world/base/fields.hpp), as those of world/api. A type with a member
/// `kAsMany` is read in place: a state has as many of it as the scene. Numbers are little
/// endian at the width of their C++ type. The bytes have no tags: keep the version of the layout
/// beside them.
///
/// Bytes from outside are read with the counts of their world. Then every number must be finite and
/// within kLargest, every enumerator one of its type, every vector of joints of the arm's size,
/// every rotation orthonormal. A type with indices or with parts that must fit together has
///
///     template <typename In>
///     void require_valid(In& in) const {
///       in.index(archive::Of::kRobot, robot);
///     }
///
/// which is called after it has been read. A type with a member `kUnbounded` may hold infinite
/// numbers.
namespace aprsim::archive {

static_assert(std::endian::native == std::endian::little);

/// Bytes that end too early or hold a value that the world cannot have.
class Damaged : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Largest magnitude of a number that is read with checks, except of lengths.
inline constexpr double kLargest = 1e30;
/// Largest coordinate of a position that is read with checks [m].
inline constexpr double kFarthest_m = 1e6;
/// Memory that the lists of one state may take.
inline constexpr std::size_t kMaxListBytes = std::size_t{64} << 20;

/// A value to read into. A type without a default constructor has a static `blank()`.
template <typename T>
[[nodiscard]] T blank() {
  if constexpr (std::default_initializable<T>) {
    return T();
  } else {
    return T::blank();
  }
}

template <typename T>
concept Plain = std::is_arithmetic_v<T> || std::is_enum_v<T>;

/// Appends values to bytes. Thread: one at a time.
class Writer {
 public:
  /// `layout`, if given, receives the place of each number and list.
  explicit Writer(std::string& out, Layout* layout = nullptr) : out_(out), layout_(layout) {}

  template <typename... T>
  void operator()(const T&... values) {
    (put(values), ...);
  }
  // Conditions on values that are read; no effect here.
  void require(bool, const char*) {}
  void begin_arm(std::ptrdiff_t) {}

 private:
  void raw(const void* bytes, std::size_t size) {
    out_.append(static_cast<const char*>(bytes), size);
  }
  void note(Layout::Kind kind, std::size_t size) {
    if (layout_ != nullptr) layout_->leaves.push_back({out_.size(), size, kind});
  }
  void count(std::size_t size) {
    note(Layout::Kind::kCount, sizeof(std::uint64_t));
    const std::uint64_t value = size;
    raw(&value, sizeof value);
  }
  /// Writes the elements and notes where each begins.
  template <typename Values, typename Put>
  void elements(const Values& values, const Put& put_one) {
    count(values.size());
    if (layout_ == nullptr) {
      for (const auto& value : values) put_one(value);
      return;
    }
    Layout::List list{.count_at = out_.size() - sizeof(std::uint64_t)};
    for (const auto& value : values) {
      list.begins.push_back(out_.size());
      put_one(value);
    }
    list.begins.push_back(out_.size());
    layout_->lists.push_back(std::move(list));
  }

  template <Plain T>
  void put(const T& value) {
    note(Layout::kind_of<T>(), sizeof value);
    raw(&value, sizeof value);
  }
  template <typename Rep, typename Period>
  void put(const std::chrono::duration<Rep, Period>& value) {
    put(value.count());
  }
  void put(const std::string& value) {
    count(value.size());
    raw(value.data(), value.size());
  }
  void put(const std::monostate&) {}
  template <typename T, std::size_t n>
  void put(const T (&values)[n]) {
    for (const T& value : values) put(value);
  }
  template <typename T, std::size_t n>
  void put(const std::array<T, n>& values) {
    for (const T& value : values) put(value);
  }
  template <typename T>
  void put(const std::vector<T>& values) {
    elements(values, [this](const T& value) { put(value); });
  }
  template <typename Key, typename T>
  void put(const std::map<Key, T>& values) {
    elements(values, [this](const auto& value) {
      this->put(value.first);
      this->put(value.second);
    });
  }
  template <typename A, typename B>
  void put(const std::pair<A, B>& value) {
    put(value.first);
    put(value.second);
  }
  template <typename T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  template <typename... T>
  void put(const std::variant<T...>& value) {
    tag(static_cast<std::uint32_t>(value.index()));
    std::visit([this](const auto& body) { this->put(body); }, value);
  }
  /// A shared value is written once: at first with its value, later by its number. 0 = null.
  template <typename T>
  void put(const std::shared_ptr<T>& value) {
    if (!value) return tag(0);
    const auto next = static_cast<std::uint32_t>(shared_.size() + 1);
    const auto [found, fresh] = shared_.emplace(value.get(), next);
    tag(found->second);
    if (fresh) put(*value);
  }
  void tag(std::uint32_t value) {
    note(Layout::Kind::kTag, sizeof value);
    raw(&value, sizeof value);
  }
  template <typename T, int rows, int columns, int options, int max_rows, int max_columns>
  void put(const Eigen::Matrix<T, rows, columns, options, max_rows, max_columns>& value) {
    if constexpr (rows == Eigen::Dynamic) put(static_cast<std::uint8_t>(value.rows()));
    if constexpr (columns == Eigen::Dynamic) put(static_cast<std::uint8_t>(value.cols()));
    if (layout_ != nullptr) {
      for (std::size_t i = 0; i < static_cast<std::size_t>(value.size()); ++i) {
        layout_->leaves.push_back({out_.size() + i * sizeof(T), sizeof(T), Layout::kind_of<T>()});
      }
    }
    raw(value.data(), sizeof(T) * static_cast<std::size_t>(value.size()));
  }
  template <typename T>
  void put(const Eigen::Quaternion<T>& value) {
    put(value.coeffs());
  }
  template <typename T, int dimension, int mode>
  void put(const Eigen::Transform<T, dimension, mode>& value) {
    put(value.matrix());
  }
  template <typename T>
  requires std::is_class_v<T>
  void put(const T& value) {
    if constexpr (requires { value.write(*this); }) {
      value.write(*this);
    } else if constexpr (requires { T::fields(value, *this); }) {
      T::fields(value, *this);
    } else {
      fields::for_each_archived(value, [&](const auto& member) { put(member); });
    }
  }

  std::string& out_;
  Layout* layout_;
  std::map<const void*, std::uint32_t> shared_;  ///< by address
};

/// Reads values in the order in which they were written, into values of the same make: members that
/// are no state keep their values. Throws Damaged. Thread: one at a time.
class Reader {
 public:
  using enum Of;

  /// Bytes that this process has written: nothing but their structure is checked.
  explicit Reader(std::string_view bytes) : left_(bytes) {}
  /// Bytes from outside, checked as said above. `counts` must outlive this.
  Reader(std::string_view bytes, const WorldCounts& counts) : left_(bytes), counts_(&counts) {}

  template <typename... T>
  void operator()(T&... values) {
    (get(values), ...);
  }
  /// Throws unless the condition on the values read so far holds.
  void require(bool condition, const char* what) {
    if (!condition) throw Damaged(what);
  }
  /// Throws unless everything has been read.
  void finish() { require(left_.empty(), "more bytes than the state has"); }

  // ---- checks; only where the counts are known
  [[nodiscard]] const WorldCounts& counts() const { return *counts_; }
  /// Throws unless each is the index of such a thing.
  template <typename... Index>
  void index(Of what, Index... indices) {
    (require_index(what, static_cast<std::int64_t>(indices), 0), ...);
  }
  /// The same, or -1.
  template <typename... Index>
  void index_or_none(Of what, Index... indices) {
    (require_index(what, static_cast<std::int64_t>(indices), -1), ...);
  }
  /// Throws unless a list has one element for each such thing.
  void one_for_each(Of what, std::size_t size) {
    if (static_cast<std::int64_t>(size) == counts_->of(what)) return;
    throw Damaged("a list has " + std::to_string(size) + " elements for " +
                  std::to_string(counts_->of(what)) + " " + name_of(what));
  }
  /// The values that follow belong to an arm with so many joints.
  void begin_arm(std::ptrdiff_t joints) { joints_ = counts_ == nullptr ? 0 : joints; }
  /// Throws unless it is the index of a joint of that arm.
  void joint(int index) {
    if (index >= 0 && index < joints_) return;
    throw Damaged("joint " + std::to_string(index) + " of an arm with " + std::to_string(joints_));
  }
  /// Throws unless a vector has a value for each joint of that arm.
  void all_joints(std::ptrdiff_t size) {
    require(joints_ == 0 || size == joints_, "a vector without a value for each joint");
  }

 private:
  void raw(void* to, std::size_t size) {
    if (left_.size() < size) throw Damaged("the bytes end in the middle of a value");
    std::memcpy(to, left_.data(), size);
    left_.remove_prefix(size);
  }
  /// The count of a list whose elements take `bytes` each in memory.
  std::size_t count(std::size_t bytes) {
    std::uint64_t size = 0;
    raw(&size, sizeof size);
    // An element takes at least one byte.
    if (size > left_.size()) throw Damaged("a list is longer than its bytes");
    if (size > list_bytes_left_ / bytes) throw Damaged("the lists take too much memory");
    list_bytes_left_ -= static_cast<std::size_t>(size) * bytes;
    return static_cast<std::size_t>(size);
  }
  void require_index(Of what, std::int64_t index, std::int64_t least) {
    if (index >= least && counts_->has(what, index)) return;
    if (index == -1 && least == -1) return;
    throw Damaged("index " + std::to_string(index) + " of " + std::to_string(counts_->of(what)) +
                  " " + name_of(what));
  }
  void require_number(double value) {
    if (std::abs(value) <= kLargest || (unbounded_ && std::isinf(value))) return;
    throw Damaged("a number is " + std::to_string(value));
  }
  template <typename T>
  void require_plain(const T& value) {
    if constexpr (std::is_enum_v<T>) {
      using Number = std::underlying_type_t<T>;
      const auto number = static_cast<std::int64_t>(static_cast<Number>(value));
      if (number >= 0 && number <= static_cast<std::int64_t>(last_of(value))) return;
      throw Damaged("an enumerator is " + std::to_string(number));
    } else if constexpr (std::is_floating_point_v<T>) {
      require_number(static_cast<double>(value));
    } else if constexpr (std::is_signed_v<T> && sizeof(T) >= 4) {
      // Counters must not overflow soon, nor sums of two.
      constexpr T kMost = std::numeric_limits<T>::max() / 4;
      if (value >= -kMost && value <= kMost) return;
      throw Damaged("a whole number is " + std::to_string(value));
    }
  }

  template <Plain T>
  void get(T& value) {
    if constexpr (std::is_enum_v<T>) {
      // An enumerator out of its range must not even be loaded.
      std::underlying_type_t<T> number{};
      raw(&number, sizeof number);
      value = static_cast<T>(number);
    } else {
      raw(&value, sizeof value);
    }
    if (counts_ != nullptr) require_plain(value);
  }
  void get(bool& value) {
    std::uint8_t byte = 0;
    raw(&byte, 1);
    require(byte <= 1, "a truth value is neither 0 nor 1");
    value = byte == 1;
  }
  template <typename Rep, typename Period>
  void get(std::chrono::duration<Rep, Period>& value) {
    Rep rep{};
    get(rep);
    value = std::chrono::duration<Rep, Period>(rep);
  }
  void get(std::string& value) {
    value.resize(count(1));
    raw(value.data(), value.size());
  }
  void get(std::monostate&) {}
  template <typename T, std::size_t n>
  void get(T (&values)[n]) {
    for (T& value : values) get(value);
  }
  template <typename T, std::size_t n>
  void get(std::array<T, n>& values) {
    for (T& value : values) get(value);
  }
  template <typename T>
  void get(std::vector<T>& values) {
    const std::size_t size = count(sizeof(T));
    if constexpr (requires { T::kAsMany; }) {
      require(size == values.size(), "another number of parts than the scene has");
      for (T& value : values) get(value);
    } else {
      values.clear();
      for (std::size_t i = 0; i < size; ++i) get(values.emplace_back(blank<T>()));
    }
  }
  template <typename Key, typename T>
  void get(std::map<Key, T>& values) {
    values.clear();
    for (std::size_t left = count(sizeof(std::pair<Key, T>)); left > 0; --left) {
      Key key = blank<Key>();
      get(key);
      get(values[std::move(key)]);
    }
  }
  template <typename A, typename B>
  void get(std::pair<A, B>& value) {
    get(value.first);
    get(value.second);
  }
  template <typename T>
  void get(std::optional<T>& value) {
    bool has = false;
    get(has);
    if constexpr (requires { T::kAsMany; }) {
      require(has == value.has_value(), "other optional parts than the scene has");
    } else if (has) {
      value.emplace(blank<T>());
    } else {
      value.reset();
    }
    if (value) get(*value);
  }
  template <typename... T>
  void get(std::variant<T...>& value) {
    std::uint32_t index = 0;
    get(index);
    require(index < sizeof...(T), "an unknown kind of value");
    get_alternative<0>(value, index);
  }
  template <std::size_t i, typename... T>
  void get_alternative(std::variant<T...>& value, std::uint32_t index) {
    if constexpr (i < sizeof...(T)) {
      if (i != index) return get_alternative<i + 1>(value, index);
      using Body = std::variant_alternative_t<i, std::variant<T...>>;
      get(value.template emplace<i>(blank<Body>()));
    }
  }
  template <typename T>
  void get(std::shared_ptr<T>& value) {
    using Value = std::remove_const_t<T>;
    std::uint32_t number = 0;
    get(number);
    if (number == 0) return value.reset();
    require(number <= shared_.size() + 1, "a shared part that is not in the state");
    if (number <= shared_.size()) {
      const Shared& known = shared_[number - 1];
      require(known.type != nullptr && *known.type == typeid(Value),
              "a shared part of another kind");
      value = std::static_pointer_cast<Value>(known.value);
      return;
    }
    const std::size_t place = shared_.size();
    shared_.push_back({});  // until it is complete
    const std::shared_ptr<Value> fresh = blank_shared<Value>();
    get(*fresh);
    shared_[place] = {fresh, &typeid(Value)};
    value = fresh;
  }
  template <typename T, int rows, int columns, int options, int max_rows, int max_columns>
  void get(Eigen::Matrix<T, rows, columns, options, max_rows, max_columns>& value) {
    std::uint8_t has_rows = static_cast<std::uint8_t>(value.rows());
    std::uint8_t has_columns = static_cast<std::uint8_t>(value.cols());
    if constexpr (rows == Eigen::Dynamic) get(has_rows);
    if constexpr (columns == Eigen::Dynamic) get(has_columns);
    require(
        (max_rows < 0 || has_rows <= max_rows) && (max_columns < 0 || has_columns <= max_columns),
        "a matrix larger than it can be");
    value.resize(has_rows, has_columns);
    raw(value.data(), sizeof(T) * static_cast<std::size_t>(value.size()));
    if (counts_ == nullptr) return;
    for (Eigen::Index i = 0; i < value.size(); ++i) require_plain(value.data()[i]);
    if constexpr (rows == Eigen::Dynamic && columns == 1) {
      require(has_rows == 0 || joints_ == 0 || has_rows == joints_,
              "a vector of another number of joints than the arm has");
    }
  }
  template <typename T>
  void get(Eigen::Quaternion<T>& value) {
    get(value.coeffs());
    if (counts_ == nullptr) return;
    require(std::abs(value.norm() - 1) < kRotationError, "a quaternion is not of unit length");
  }
  template <typename T, int dimension, int mode>
  void get(Eigen::Transform<T, dimension, mode>& value) {
    get(value.matrix());
    if constexpr (mode == Eigen::Isometry) {
      if (counts_ != nullptr) require_rigid(value);
    }
  }
  void require_rigid(const Eigen::Isometry3d& X) {
    const Eigen::Matrix3d R = X.linear();
    const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).norm();
    require(error < kRotationError && R.determinant() > 0, "a rotation is not orthonormal");
    require(X.translation().cwiseAbs().maxCoeff() <= kFarthest_m, "a position is too far away");
    require(X.matrix().row(3) == Eigen::RowVector4d(0, 0, 0, 1), "a pose is no rigid motion");
  }
  template <typename T>
  requires std::is_class_v<T>
  void get(T& value) {
    const bool unbounded = unbounded_;
    if constexpr (requires { T::kUnbounded; }) unbounded_ = true;
    read_members(value);
    unbounded_ = unbounded;
    if constexpr (requires { value.require_valid(*this); }) {
      if (counts_ != nullptr) value.require_valid(*this);
    }
  }
  template <typename T>
  void read_members(T& value) {
    if constexpr (requires { value.read(*this); }) {
      value.read(*this);
    } else if constexpr (requires { T::fields(value, *this); }) {
      T::fields(value, *this);
    } else {
      fields::for_each_archived(value, [&](auto& member) { get(member); });
    }
  }

  template <typename T>
  static std::shared_ptr<T> blank_shared() {
    if constexpr (std::default_initializable<T>) {
      return std::make_shared<T>();
    } else {
      return std::make_shared<T>(T::blank());
    }
  }

  struct Shared {
    std::shared_ptr<void> value;
    const std::type_info* type = nullptr;
  };
  static constexpr double kRotationError = 1e-6;

  std::string_view left_;
  const WorldCounts* counts_ = nullptr;  ///< null = no checks of values
  std::ptrdiff_t joints_ = 0;            ///< of the present arm; 0 = none
  bool unbounded_ = false;               ///< infinite numbers are allowed
  std::size_t list_bytes_left_ = kMaxListBytes;
  std::vector<Shared> shared_;  ///< by number, from 1
};

}  // namespace aprsim::archive
