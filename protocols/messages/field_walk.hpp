#pragma once

#include <concepts>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>

#include <google/protobuf/message_lite.h>

#include "protocols/messages/enum_match.hpp"
#include "world/base/fields.hpp"
#include "world/base/result.hpp"

/// Writes values into messages and reads them by their lists of fields (world/base/fields.hpp). The
/// names of the lists are the generated accessors of the messages, so a walk is as fast as a
/// hand-written function. Include codecs.hpp for values without one-to-one fields.
namespace aprsim::protocols {

/// Codec of a value without one-to-one fields:
/// `static void write(const T&, Message&)` and `static Result<void> read(const Message&, T&)`.
/// For a value that messages have as a number, `static Number number(const T&)` and
/// `static T value(Number)`.
template <typename T>
struct Codec;

/// Writes a value that has a list, a codec, or a variant. Its fields must be unset before.
template <typename T, typename M>
void write_value(const T& value, M& message);

/// Reads such a value. The member of an absent field stays as it is. Errors: kInvalidArgument with
/// the name of a field whose value this version does not know.
template <typename M, typename T>
[[nodiscard]] Result<void> read_value(const M& message, T& value);

namespace walk {

// The kinds of members.
template <typename T>
concept Text = std::is_same_v<T, std::string> || std::is_same_v<T, std::string_view>;
template <typename T>
concept Variant = requires {
  std::variant_size<T>::value;
};
template <typename T>
concept Map = requires {
  typename T::mapped_type;
};
template <typename T>
concept List = !Text<T> && !Map<T> && requires(const T& list) {
  list.begin(), list.max_size();
};
template <typename T>
concept Optional = requires(T optional) {
  optional.has_value(), optional.emplace();
};
template <typename T>
concept Shared = requires(const T& pointer) {
  pointer.use_count();
};

// The kinds of a message's fields.
template <typename T>
concept Message = std::derived_from<T, google::protobuf::MessageLite>;
template <typename Access, typename M>
using TypeOf = std::remove_cvref_t<decltype(std::declval<const Access&>()(
    fields::Get(), std::declval<const M&>()))>;
template <typename Access, typename M>
concept HasPresence =
    decltype(std::declval<const Access&>()(fields::HasPresence(), std::declval<const M&>()))::value;

// The kinds of places (world/base/fields.hpp).
template <typename Place>
concept Within = requires(const Place& place) {
  place.place;
};
template <typename Place>
concept Named = !Within<Place> && requires(const Place& place) {
  place.access;
};
template <typename Place>
concept Omitted = std::is_same_v<Place, fields::Omitted>;

/// Calls `use` with the value that represents the struct in messages.
template <typename T, typename Use>
void with_alone(T& value, Use&& use) {
  fields::for_each<std::remove_const_t<T>>([&]<typename Field>(const Field& each) {
    if constexpr (std::is_same_v<decltype(Field::place), fields::Alone>) use(value.*each.member);
  });
}

/// Calls `use` with each fields::Alternative of a variant.
template <typename V, typename Use>
void for_each_alternative(Use&& use) {
  constexpr auto list = alternatives_of(static_cast<const V*>(nullptr));
  std::apply([&](const auto&... each) { (use(each), ...); }, list.all);
}

// ---- Writing.

/// Calls `set` with the number or text that messages have for the value.
template <typename T, typename Set>
void with_scalar(const T& value, Set&& set) {
  if constexpr (std::is_enum_v<T>) {
    set(to_message(value));
  } else if constexpr (std::is_same_v<T, std::string_view>) {
    set(std::string(value));
  } else if constexpr (std::is_arithmetic_v<T> || Text<T>) {
    set(value);
  } else if constexpr (requires { Codec<T>::number(value); }) {
    set(Codec<T>::number(value));
  } else if constexpr (std::is_empty_v<T>) {
    set(true);
  } else {
    with_alone(value, [&](const auto& alone) { with_scalar(alone, set); });
  }
}

template <typename Access, typename T, typename M>
void write_named(const Access& access, const T& value, M& message) {
  using Type = TypeOf<Access, M>;
  const auto set = [&](const auto& scalar) { access(fields::Set(), message, scalar); };
  if constexpr (Optional<T> || Shared<T>) {
    if (value) write_named(access, *value, message);
  } else if constexpr (Map<T>) {
    auto& map = *access(fields::Mutable(), message);
    for (const auto& [key, each] : value) map[key] = each;
  } else if constexpr (List<T>) {
    for (const auto& each : value) {
      if constexpr (Message<typename Type::value_type>) {
        write_value(each, *access(fields::Add(), message));
      } else {
        with_scalar(each, [&](const auto& scalar) { access(fields::Add(), message, scalar); });
      }
    }
  } else if constexpr (Message<Type>) {
    write_value(value, *access(fields::Mutable(), message));
  } else if constexpr (std::is_same_v<T, int> && HasPresence<Access, M>) {
    if (value >= 0) set(static_cast<Type>(value));  // an index is negative when there is none
  } else if constexpr (std::is_integral_v<T>) {
    set(static_cast<Type>(value));
  } else {
    with_scalar(value, set);
  }
}

template <typename Place, typename T, typename M>
void write_at(const Place& place, const T& value, M& message) {
  if constexpr (Within<Place>) {
    write_at(place.place, value, *place.access(fields::Mutable(), message));
  } else if constexpr (Named<Place>) {
    write_named(place.access, value, message);
  } else if constexpr (Optional<T>) {
    if (value) write_at(place, *value, message);
  } else if constexpr (!Omitted<Place>) {
    write_value(value, message);
  }
}

template <typename V, typename M>
void write_alternative(const V& value, M& message) {
  for_each_alternative<V>(
      [&]<typename T, typename Place>(const fields::Alternative<T, Place>& each) {
        if (const T* held = std::get_if<T>(&value)) write_at(each.place, *held, message);
      });
}

// ---- Reading.

template <typename Type, typename T>
[[nodiscard]] Result<void> read_scalar(const Type& scalar, T& value) {
  Result<void> result;
  if constexpr (std::is_enum_v<T>) {
    result = from_message<T>(static_cast<int>(scalar)).map([&](T known) { value = known; });
  } else if constexpr (std::is_arithmetic_v<T> || Text<T>) {
    value = static_cast<T>(scalar);
  } else if constexpr (requires { Codec<T>::value(scalar); }) {
    value = Codec<T>::value(scalar);
  } else if constexpr (!std::is_empty_v<T>) {
    with_alone(value, [&](auto& alone) { result = read_scalar(scalar, alone); });
  }
  return result;
}

template <typename Type, typename T>
[[nodiscard]] Result<void> read_one(const Type& from, T& value) {
  if constexpr (Message<Type>) {
    return read_value(from, value);
  } else {
    return read_scalar(from, value);
  }
}

template <typename Access, typename M, typename T>
[[nodiscard]] Result<void> read_named(const Access& access, const M& message, T& value) {
  Result<void> result;
  if constexpr (Map<T>) {
    for (const auto& [key, each] : access(fields::Get(), message)) value[key] = each;
  } else if constexpr (List<T>) {
    for (const auto& each : access(fields::Get(), message)) {
      if (result) result = read_one(each, value.emplace_back());
    }
  } else if constexpr (Optional<T>) {
    if (access(fields::Has(), message)) result = read_named(access, message, value.emplace());
  } else if constexpr (HasPresence<Access, M>) {
    if (access(fields::Has(), message)) result = read_one(access(fields::Get(), message), value);
  } else {
    result = read_one(access(fields::Get(), message), value);
  }
  return result;
}

template <typename Place, typename M, typename T>
[[nodiscard]] Result<void> read_at(const Place& place, const M& message, T& value) {
  if constexpr (Within<Place>) {
    return read_at(place.place, place.access(fields::Get(), message), value);
  } else if constexpr (Named<Place>) {
    return read_named(place.access, message, value);
  } else if constexpr (Omitted<Place>) {
    return {};
  } else if constexpr (Optional<T>) {
    using Inlined = typename T::value_type;  // is there when the message has its first field
    constexpr auto first = std::get<0>(fields_of(static_cast<const Inlined*>(nullptr)));
    if (!first.place.access(fields::Has(), message)) return {};
    return read_value(message, value.emplace());
  } else {
    return read_value(message, value);
  }
}

/// Whether the message's oneof has one of the variant's types.
template <typename V, typename M>
[[nodiscard]] bool has_any(const M& message) {
  bool any = false;
  for_each_alternative<V>(
      [&]<typename T, typename Place>(const fields::Alternative<T, Place>& each) {
        if constexpr (Named<Place>) {
          any = any || each.place.access(fields::Has(), message);
        } else if constexpr (!Omitted<Place>) {
          any = any || has_any<T>(message);
        }
      });
  return any;
}

template <typename M, typename V>
[[nodiscard]] Result<void> read_alternative(const M& message, V& value) {
  constexpr auto list = alternatives_of(static_cast<const V*>(nullptr));
  if (!has_any<V>(message)) {
    if (std::is_same_v<std::variant_alternative_t<0, V>, std::monostate>) return {};
    return unknown(list.noun);
  }
  Result<void> result;
  for_each_alternative<V>(
      [&]<typename T, typename Place>(const fields::Alternative<T, Place>& each) {
        if constexpr (Named<Place>) {
          if (!each.place.access(fields::Has(), message)) return;
          result = read_at(each.place, message, value.template emplace<T>());
        } else if constexpr (!Omitted<Place>) {
          if (has_any<T>(message))
            result = read_at(each.place, message, value.template emplace<T>());
        }
      });
  return result;
}

}  // namespace walk

/// Writes the fields of `value`, without its codec. They must be unset in the message.
template <fields::Listed T, typename M>
void write_fields(const T& value, M& message) {
  fields::for_each<T>(
      [&](const auto& each) { walk::write_at(each.place, value.*each.member, message); });
}

/// Reads the fields of `value`, without its codec.
template <fields::Listed T, typename M>
[[nodiscard]] Result<void> read_fields(const M& message, T& value) {
  Result<void> result;
  fields::for_each<T>([&](const auto& each) {
    if (result) result = walk::read_at(each.place, message, value.*each.member);
  });
  return result;
}

template <typename T, typename M>
void write_value(const T& value, M& message) {
  if constexpr (requires { Codec<T>::write(value, message); }) {
    Codec<T>::write(value, message);
  } else if constexpr (walk::Variant<T>) {
    walk::write_alternative(value, message);
  } else {
    write_fields(value, message);
  }
}

template <typename M, typename T>
Result<void> read_value(const M& message, T& value) {
  if constexpr (requires { Codec<T>::read(message, value); }) {
    return Codec<T>::read(message, value);
  } else if constexpr (walk::Variant<T>) {
    return walk::read_alternative(message, value);
  } else {
    return read_fields(message, value);
  }
}

}  // namespace aprsim::protocols
