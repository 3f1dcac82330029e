#include "protocols/modbus/security/role_extension.hpp"

#include <algorithm>
#include <memory>
#include <openssl/asn1.h>
#include <openssl/err.h>
#include <openssl/x509.h>
#include <utility>

namespace aprsim::modbus_server {
namespace {

struct FreeDecoded {
  void operator()(ASN1_UTF8STRING* text) const { ASN1_UTF8STRING_free(text); }
  void operator()(ASN1_OBJECT* object) const { ASN1_OBJECT_free(object); }
  void operator()(unsigned char* bytes) const { OPENSSL_free(bytes); }
};
using Bytes = std::unique_ptr<unsigned char, FreeDecoded>;

tl::unexpected<Error> wrong(const std::string& message) {
  ERR_clear_error();  // of the thread, which other connections share
  return fail(ErrorCode::kInvalidArgument, "role", "the role in its certificate " + message);
}

/// Whether these bytes are the DER of the text. The decoder also accepts other encodings.
bool is_der_of(const ASN1_UTF8STRING* text, std::span<const std::uint8_t> bytes) {
  unsigned char* made = nullptr;
  const int size = i2d_ASN1_UTF8STRING(text, &made);
  const Bytes owner(made);
  return size >= 0 && std::ranges::equal(std::span(made, static_cast<std::size_t>(size)), bytes);
}

}  // namespace

Result<std::string> role_in(std::span<const std::uint8_t> extension) {
  constexpr std::size_t kMostHeader = 4;  // tag and length of so short a text
  if (extension.size() > kMaxRoleSize + kMostHeader) return wrong("is too long");
  const unsigned char* next = extension.data();
  const std::unique_ptr<ASN1_UTF8STRING, FreeDecoded> text(
      d2i_ASN1_UTF8STRING(nullptr, &next, static_cast<long>(extension.size())));
  if (!text || !is_der_of(text.get(), extension)) return wrong("is no UTF8String in DER");
  unsigned char* utf8 = nullptr;
  const int size = ASN1_STRING_to_UTF8(&utf8, text.get());
  const Bytes owner(utf8);
  if (size < 0) return wrong("is not UTF-8");
  std::string role(reinterpret_cast<const char*>(utf8), static_cast<std::size_t>(size));
  if (role.empty()) return wrong("is empty");
  if (role.size() > kMaxRoleSize) return wrong("is too long");
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '\x7F'; };
  if (std::ranges::any_of(role, is_control)) return wrong("has control characters");
  return role;
}

Result<std::optional<std::string>> role_of(const x509_st* certificate) {
  const std::unique_ptr<ASN1_OBJECT, FreeDecoded> oid(OBJ_txt2obj(kRoleOid, 1));
  const int at = X509_get_ext_by_OBJ(certificate, oid.get(), -1);
  if (at < 0) return std::optional<std::string>();
  if (X509_get_ext_by_OBJ(certificate, oid.get(), at) >= 0) return wrong("is not the only one");
  const ASN1_OCTET_STRING* content = X509_EXTENSION_get_data(X509_get_ext(certificate, at));
  auto role = role_in({ASN1_STRING_get0_data(content),
                       static_cast<std::size_t>(std::max(ASN1_STRING_length(content), 0))});
  if (!role) return tl::unexpected(role.error());
  return std::optional(std::move(*role));
}

}  // namespace aprsim::modbus_server
