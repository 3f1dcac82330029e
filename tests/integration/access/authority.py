"""A certificate authority of the tests' own, and what it certifies: by the command `openssl`."""

from __future__ import annotations

import pathlib
import ssl
import subprocess
from dataclasses import dataclass


@dataclass(frozen=True)
class Certified:
    """Files in PEM."""

    certificate: str
    key: str


def _openssl(*arguments: str) -> None:
    done = subprocess.run(["openssl", *arguments], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"openssl {' '.join(arguments)}: {done.stderr}")


class Authority:
    """Makes certificates in a directory, each with a key of its own."""

    def __init__(self, directory: str, name: str = "ca") -> None:
        self.directory = pathlib.Path(directory)
        self.certificate = str(self.directory / f"{name}.pem")
        self._key = str(self.directory / f"{name}.key")
        _openssl(
            "req", "-x509", *self._new_key(self._key), "-out", self.certificate, "-days", "2",
            "-subj", f"/CN=Authority {name}",
        )

    def certify(
        self, name: str, names: str = "", *, days: int = 1, extensions: tuple[str, ...] = ()
    ) -> Certified:
        """`name` is the common one, `names` are alternatives as OpenSSL writes them ("DNS:a,IP:b");
        with days below 0 it has expired. `extensions` are lines of OpenSSL, "OID=ASN1:UTF8String:a"."""
        base = self.directory / name.replace("/", "_").replace(" ", "_")
        made = Certified(f"{base}.pem", f"{base}.key")
        _openssl("req", "-new", *self._new_key(made.key), "-out", f"{base}.csr", "-subj", f"/CN={name}")
        lines = ([f"subjectAltName={names}"] if names else []) + list(extensions)
        file = pathlib.Path(f"{base}.ext")
        file.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
        _openssl(
            "x509", "-req", "-in", f"{base}.csr", "-CA", self.certificate, "-CAkey", self._key,
            "-CAcreateserial", "-days", str(days), "-extfile", str(file), "-out", made.certificate,
        )
        return made

    def alter(self, made: Certified, old: bytes, new: bytes) -> None:
        """Replaces bytes of a certificate by as many others, and signs it again: OpenSSL's command makes
        none with faults."""
        der = ssl.PEM_cert_to_DER_cert(pathlib.Path(made.certificate).read_text(encoding="utf-8"))

        def end(at: int) -> int:
            """End of the element there. Its length has one byte, or two behind 0x82."""
            return at + (4 + int.from_bytes(der[at + 2 : at + 4], "big") if der[at + 1] == 0x82 else 2 + der[at + 1])

        signed = der[4 : end(4)].replace(old, new)
        algorithm = der[end(4) : end(end(4))]
        file = self.directory / "signed.der"
        file.write_bytes(signed)
        signature = subprocess.run(
            ["openssl", "dgst", "-sha256", "-sign", self._key, str(file)], capture_output=True, check=True
        ).stdout
        content = signed + algorithm + bytes([3, len(signature) + 1, 0]) + signature
        whole = b"\x30\x82" + len(content).to_bytes(2, "big") + content
        pathlib.Path(made.certificate).write_text(ssl.DER_cert_to_PEM_cert(whole), encoding="utf-8")

    @staticmethod
    def _new_key(path: str) -> list[str]:
        return ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-keyout", path]
