#pragma once

#include <array>
#include <bit>
#include <chrono>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
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

#include "world/base/fields.hpp"

/// Values as bytes and back, bit for bit: what a saved state is on a disk. A type lists what it has
/// in one function for both directions, by a structured binding of all its members, so that one
/// that is added without a decision does not compile:
///
///     template <typename Self, typename Io>
///     static void fields(Self& self, Io& io) {
///       auto& [position, speed, limits] = self;
///       io(position, speed);  // the limits are the scene's
///     }
///
/// or it has a list of fields (world/base/fields.hpp), as those of world/api. A type with a member
/// `kAsMany` is read in place: a state has as many of it as the scene. Numbers are little
/// endian at the width of their C++ type. Nothing but order says what a byte means: who keeps bytes
/// keeps the version of the layout beside them.
namespace aprsim::archive {

static_assert(std::endian::native == std::endian::little);

/// What bytes say that no value can have, or where they end too early.
class Damaged : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A value to read into; of a type without a default constructor what its static `blank()` makes.
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
  explicit Writer(std::string& out) : out_(out) {}

  template <typename... T>
  void operator()(const T&... values) {
    (put(values), ...);
  }
  /// A condition on what is read; here nothing.
  void require(bool, const char*) {}

 private:
  void raw(const void* bytes, std::size_t size) {
    out_.append(static_cast<const char*>(bytes), size);
  }
  void count(std::size_t size) { put(static_cast<std::uint64_t>(size)); }

  template <Plain T>
  void put(const T& value) {
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
    count(values.size());
    for (const T& value : values) put(value);
  }
  template <typename Key, typename T>
  void put(const std::map<Key, T>& values) {
    count(values.size());
    for (const auto& [key, value] : values) {
      put(key);
      put(value);
    }
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
    put(static_cast<std::uint32_t>(value.index()));
    std::visit([this](const auto& body) { put(body); }, value);
  }
  /// What several share is written once: at first with its value, later by its number. 0 = null.
  template <typename T>
  void put(const std::shared_ptr<T>& value) {
    if (!value) return put(std::uint32_t{0});
    const auto next = static_cast<std::uint32_t>(shared_.size() + 1);
    const auto [found, fresh] = shared_.emplace(value.get(), next);
    put(found->second);
    if (fresh) put(*value);
  }
  template <typename T, int rows, int columns, int options, int max_rows, int max_columns>
  void put(const Eigen::Matrix<T, rows, columns, options, max_rows, max_columns>& value) {
    if constexpr (rows == Eigen::Dynamic) put(static_cast<std::uint8_t>(value.rows()));
    if constexpr (columns == Eigen::Dynamic) put(static_cast<std::uint8_t>(value.cols()));
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
  std::map<const void*, std::uint32_t> shared_;  ///< by address
};

/// Reads values in the order in which they were written, into values of the same make: members that
/// are no state keep what they have. Throws Damaged. Thread: one at a time.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : left_(bytes) {}

  template <typename... T>
  void operator()(T&... values) {
    (get(values), ...);
  }
  /// Throws unless what has been read so far can be.
  void require(bool condition, const char* what) {
    if (!condition) throw Damaged(what);
  }
  /// Throws unless everything has been read.
  void finish() { require(left_.empty(), "more bytes than the state has"); }

 private:
  void raw(void* to, std::size_t size) {
    if (left_.size() < size) throw Damaged("the bytes end in the middle of a value");
    std::memcpy(to, left_.data(), size);
    left_.remove_prefix(size);
  }
  std::size_t count() {
    std::uint64_t size = 0;
    get(size);
    // Whatever it counts takes a byte at least.
    if (size > left_.size()) throw Damaged("a list is longer than its bytes");
    return static_cast<std::size_t>(size);
  }

  template <Plain T>
  void get(T& value) {
    raw(&value, sizeof value);
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
    value.resize(count());
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
    const std::size_t size = count();
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
    for (std::size_t left = count(); left > 0; --left) {
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
      require(has == value.has_value(), "a part that the scene has not, or lacks one that it has");
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
    require(index < sizeof...(T), "a kind that there is not");
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
    require(number <= shared_.size() + 1, "a shared part that has not been written");
    if (number <= shared_.size()) {
      const Shared& known = shared_[number - 1];
      require(known.type != nullptr && *known.type == typeid(Value),
              "a shared part of another kind");
      value = std::static_pointer_cast<Value>(known.value);
      return;
    }
    const std::size_t place = shared_.size();
    shared_.push_back({});  // its own parts come before it is whole
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
  }
  template <typename T>
  void get(Eigen::Quaternion<T>& value) {
    get(value.coeffs());
  }
  template <typename T, int dimension, int mode>
  void get(Eigen::Transform<T, dimension, mode>& value) {
    get(value.matrix());
  }
  template <typename T>
  requires std::is_class_v<T>
  void get(T& value) {
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
  std::string_view left_;
  std::vector<Shared> shared_;  ///< by number, from 1
};

}  // namespace aprsim::archive
