"""A certificate authority of the tests' own, and what it certifies: by the command `openssl`."""

from __future__ import annotations

import pathlib
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

    def certify(self, name: str, names: str = "", *, days: int = 1) -> Certified:
        """`name` is the common one, `names` are alternatives as OpenSSL writes them ("DNS:a,IP:b");
        with days below 0 it has expired."""
        base = self.directory / name.replace("/", "_").replace(" ", "_")
        made = Certified(f"{base}.pem", f"{base}.key")
        _openssl("req", "-new", *self._new_key(made.key), "-out", f"{base}.csr", "-subj", f"/CN={name}")
        extensions = pathlib.Path(f"{base}.ext")
        extensions.write_text(f"subjectAltName={names}\n" if names else "", encoding="utf-8")
        _openssl(
            "x509", "-req", "-in", f"{base}.csr", "-CA", self.certificate, "-CAkey", self._key,
            "-CAcreateserial", "-days", str(days), "-extfile", str(extensions), "-out", made.certificate,
        )
        return made

    @staticmethod
    def _new_key(path: str) -> list[str]:
        return ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-keyout", path]
