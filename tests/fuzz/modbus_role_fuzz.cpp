// Bytes as the content of the role extension of a client's certificate, alone and in a certificate.
// First byte: how many such extensions the certificate has, by its lowest two bits.

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <openssl/asn1.h>
#include <openssl/x509.h>
#include <span>
#include <string>
#include <string_view>

#include "protocols/modbus/security/role_extension.hpp"

namespace {

using namespace aprsim::modbus_server;

void demand(bool truth) {
  if (!truth) std::abort();
}

struct Free {
  void operator()(X509* certificate) const { X509_free(certificate); }
  void operator()(X509_EXTENSION* extension) const { X509_EXTENSION_free(extension); }
  void operator()(ASN1_OBJECT* object) const { ASN1_OBJECT_free(object); }
  void operator()(ASN1_OCTET_STRING* bytes) const { ASN1_OCTET_STRING_free(bytes); }
};

/// The DER of a UTF8String, by X.690 alone.
std::string der_of(const std::string& text) {
  std::string out = "\x0C";
  if (text.size() >= 0x100) {
    out += '\x82';
    out += static_cast<char>(text.size() >> 8U);
  } else if (text.size() >= 0x80) {
    out += '\x81';
  }
  out += static_cast<char>(text.size() & 0xFFU);
  return out + text;
}

/// Whether a text is UTF-8 (RFC 3629), decoded here a second time.
bool is_utf8(const std::string& text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const std::size_t size = lead < 0x80 ? 1 : lead >> 5U == 6 ? 2 : lead >> 4U == 14 ? 3 : 4;
    if ((size == 4 && lead >> 3U != 30) || i + size > text.size()) return false;
    unsigned code = size == 1 ? lead : lead & (0xFFU >> (size + 1));
    for (std::size_t k = 1; k < size; ++k) {
      const auto next = static_cast<unsigned char>(text[i + k]);
      if (next >> 6U != 2) return false;
      code = code << 6U | (next & 0x3FU);
    }
    constexpr unsigned kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
    if (code < kLeast[size] || code > 0x10FFFF || (code >= 0xD800 && code < 0xE000)) return false;
    i += size;
  }
  return true;
}

std::unique_ptr<X509, Free> certificate_with(std::span<const std::uint8_t> content, int times) {
  std::unique_ptr<X509, Free> certificate(X509_new());
  const std::unique_ptr<ASN1_OBJECT, Free> oid(OBJ_txt2obj(kRoleOid, 1));
  const std::unique_ptr<ASN1_OCTET_STRING, Free> bytes(ASN1_OCTET_STRING_new());
  ASN1_OCTET_STRING_set(bytes.get(), content.data(), static_cast<int>(content.size()));
  for (int i = 0; i < times; ++i) {
    const std::unique_ptr<X509_EXTENSION, Free> extension(
        X509_EXTENSION_create_by_OBJ(nullptr, oid.get(), 0, bytes.get()));
    X509_add_ext(certificate.get(), extension.get(), -1);
  }
  return certificate;
}

void check(std::span<const std::uint8_t> content, int times) {
  const auto role = role_in(content);
  if (role) {
    demand(!role->empty() && role->size() <= kMaxRoleSize && is_utf8(*role));
    for (const char c : *role) demand(static_cast<unsigned char>(c) >= ' ' && c != '\x7F');
    const std::string_view given(reinterpret_cast<const char*>(content.data()), content.size());
    demand(der_of(*role) == given);
  } else {
    demand(role.error().field == "role" && !role.error().message.empty());
  }
  const auto found = role_of(certificate_with(content, times).get());
  if (times == 0) {
    demand(found && !*found);
  } else if (times > 1 || !role) {
    demand(!found);
  } else {
    demand(found && *found == *role);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  check({data + 1, size - 1}, data[0] & 3);
  return 0;
}
