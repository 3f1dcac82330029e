"""Parameters of a cell estimated from recordings of the real one, and recordings compared with a scene.

    python3 -m aprsim.calibration calibrate lab.journal --scene aprs_lab --out fitted.yaml
    python3 -m aprsim.calibration compare lab.journal --scene fitted.yaml

In Python these are `calibrating.calibrate` and `comparing.compare`. They need scipy and PyYAML (Debian:
`python3-scipy`, `python3-yaml`)."""
