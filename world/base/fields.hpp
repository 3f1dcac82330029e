#pragma once

#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>

/// The fields of plain values, listed once for all that write and read them: archives
/// (world/archive) and messages (protocols/messages). A list stands beside its struct, in the
/// namespace of the struct, with one entry for each member in their order:
///
///     APRSIM_FIELDS(Waypoint, FIELD_AS(X_RT, tool_in_robot), INLINED(limits), INLINED(tolerance))
///
/// A list that lacks a member does not compile. An archive has all members but those that are
/// NOWHERE. A list knows the names of a message's fields, but no message.
namespace aprsim::fields {

// The requests to a field of a message. An access is a callable that carries them out.
struct Get {};
struct Set {};
struct Mutable {};
struct Add {};
struct Has {};
struct HasPresence {};  ///< std::true_type if the field has presence in the message

/// The field of a message under a name.
template <typename Access>
struct Named {
  Access access;
};
template <typename Access>
constexpr Named<Access> named(Access access) {
  return {access};
}

/// The fields of the value stand in the message itself.
struct Inlined {};
/// The value stands in a message in the message.
template <typename Access, typename Place>
struct Within {
  Access access;
  Place place;
};
template <typename Access, typename Place>
constexpr Within<Access, Place> within(Access access, Place place) {
  return {access, place};
}

/// The struct is represented by this value alone.
struct Alone {};
/// Hand-written code converts it, or no message has it.
struct Omitted {};

template <typename Member, typename Place, bool archived>
struct Field {
  static constexpr bool kArchived = archived;
  Member member;
  Place place;
};

template <bool archived = true, typename Member, typename Place>
constexpr Field<Member, Place, archived> field(Member member, Place place) {
  return {member, place};
}

/// One type that a variant can hold, and its field of the message's oneof.
template <typename T, typename Place>
struct Alternative {
  using Type = T;
  Place place;
};
template <typename T, typename Place>
constexpr Alternative<T, Place> alternative(Place place) {
  return {place};
}

template <typename... T>
struct Alternatives {
  const char* noun;  ///< names the variant in errors
  std::tuple<T...> all;
};
template <typename... T>
constexpr Alternatives<T...> alternatives(const char* noun, T... all) {
  return {noun, {all...}};
}

template <typename Variant, typename... T>
consteval bool matches(const Alternatives<T...>&) {
  return std::is_same_v<Variant, std::variant<typename T::Type...>>;
}

/// Converts to every type, in unevaluated code.
struct AnyValue {
  template <typename T>
  operator T() const;
};

/// Whether the fields are all members of T in order: T is an aggregate of exactly that many
/// members.
template <typename T, typename... Members, typename... Places, bool... archived>
consteval bool is_complete(const std::tuple<Field<Members T::*, Places, archived>...>&) {
  constexpr bool kTakesThem = requires { T{std::declval<Members>()...}; };
  constexpr bool kTakesMore = requires { T{std::declval<Members>()..., AnyValue()}; };
  return kTakesThem && !kTakesMore;
}

template <typename T>
concept Listed = requires(const T* type) {
  fields_of(type);
};

/// Calls `use` with the Field of each member of T.
template <Listed T, typename Use>
constexpr void for_each(Use&& use) {
  constexpr auto all = fields_of(static_cast<const T*>(nullptr));
  std::apply([&](const auto&... each) { (use(each), ...); }, all);
}

/// Calls `use` with each member of `value` that archives have.
template <typename T, typename Use>
requires Listed<std::remove_const_t<T>>
constexpr void for_each_archived(T& value, Use&& use) {
  for_each<std::remove_const_t<T>>([&](const auto& each) {
    if constexpr (std::remove_cvref_t<decltype(each)>::kArchived) use(value.*each.member);
  });
}

}  // namespace aprsim::fields

#define APRSIM_ACCESS(NAME)                                                    \
  [](auto request, auto& message, const auto&... value) -> decltype(auto) {    \
    using Request = decltype(request);                                         \
    if constexpr (std::is_same_v<Request, ::aprsim::fields::Get>) {            \
      return message.NAME();                                                   \
    } else if constexpr (std::is_same_v<Request, ::aprsim::fields::Set>) {     \
      return message.set_##NAME(value...);                                     \
    } else if constexpr (std::is_same_v<Request, ::aprsim::fields::Mutable>) { \
      return message.mutable_##NAME();                                         \
    } else if constexpr (std::is_same_v<Request, ::aprsim::fields::Add>) {     \
      return message.add_##NAME(value...);                                     \
    } else if constexpr (std::is_same_v<Request, ::aprsim::fields::Has>) {     \
      return message.has_##NAME();                                             \
    } else {                                                                   \
      constexpr bool kHasPresence = requires { message.has_##NAME(); };        \
      return std::bool_constant<kHasPresence>();                               \
    }                                                                          \
  }

/// Lists the fields of a struct. Entries:
/// FIELD(member): has the same name in messages.
/// FIELD_AS(member, name): has that name in messages.
/// FIELD_IN(message, member, name): has that name in that message of the struct's message.
/// INLINED(member): its fields stand in the struct's message; of a variant its oneof.
/// INLINED_IN(message, member): its fields stand in that message of the struct's message.
/// ALONE(member): messages have this value in place of the struct.
/// BY_HAND(member): hand-written code of protocols/messages converts it.
/// ARCHIVE_ONLY(member): messages do not have it.
/// NOWHERE(member): neither messages nor archives have it.
#define APRSIM_FIELDS(TYPE, ...)                                                   \
  template <typename Self = TYPE>                                                  \
  constexpr auto fields_of(const TYPE*) {                                          \
    constexpr auto kList = std::make_tuple(__VA_ARGS__);                           \
    static_assert(::aprsim::fields::is_complete<Self>(kList),                      \
                  "a list of fields has one entry for each member of its struct"); \
    return kList;                                                                  \
  }
#define APRSIM_NAMED(NAME) ::aprsim::fields::named(APRSIM_ACCESS(NAME))
#define APRSIM_WITHIN(MESSAGE, PLACE) ::aprsim::fields::within(APRSIM_ACCESS(MESSAGE), PLACE)
#define FIELD(MEMBER) FIELD_AS(MEMBER, MEMBER)
#define FIELD_AS(MEMBER, NAME) ::aprsim::fields::field(&Self::MEMBER, APRSIM_NAMED(NAME))
#define FIELD_IN(MESSAGE, MEMBER, NAME) \
  ::aprsim::fields::field(&Self::MEMBER, APRSIM_WITHIN(MESSAGE, APRSIM_NAMED(NAME)))
#define INLINED(MEMBER) ::aprsim::fields::field(&Self::MEMBER, ::aprsim::fields::Inlined())
#define INLINED_IN(MESSAGE, MEMBER) \
  ::aprsim::fields::field(&Self::MEMBER, APRSIM_WITHIN(MESSAGE, ::aprsim::fields::Inlined()))
#define ALONE(MEMBER) ::aprsim::fields::field(&Self::MEMBER, ::aprsim::fields::Alone())
#define BY_HAND(MEMBER) ::aprsim::fields::field(&Self::MEMBER, ::aprsim::fields::Omitted())
#define ARCHIVE_ONLY(MEMBER) BY_HAND(MEMBER)
#define NOWHERE(MEMBER) ::aprsim::fields::field<false>(&Self::MEMBER, ::aprsim::fields::Omitted())

/// Lists the types of a variant in their order; NOUN names the variant in errors. Entries:
/// ALTERNATIVE(type, name): has that name in the message's oneof.
/// INLINED_ALTERNATIVE(type): a variant with its own list, whose types stand in the same oneof.
/// NO_ALTERNATIVE: std::monostate, where nothing of the oneof is set.
#define APRSIM_ALTERNATIVES(VARIANT, NOUN, ...)                                     \
  template <typename Self = VARIANT>                                                \
  constexpr auto alternatives_of(const VARIANT*) {                                  \
    constexpr auto kList = ::aprsim::fields::alternatives(NOUN, __VA_ARGS__);       \
    static_assert(::aprsim::fields::matches<Self>(kList),                           \
                  "a list of alternatives has the types of its variant, in order"); \
    return kList;                                                                   \
  }
#define ALTERNATIVE(TYPE, NAME) ::aprsim::fields::alternative<TYPE>(APRSIM_NAMED(NAME))
#define INLINED_ALTERNATIVE(TYPE) ::aprsim::fields::alternative<TYPE>(::aprsim::fields::Inlined())
#define NO_ALTERNATIVE ::aprsim::fields::alternative<std::monostate>(::aprsim::fields::Omitted())
