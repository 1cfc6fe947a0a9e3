#!/bin/sh
# Makes what the image holds beside Python itself: a virtual environment with the vehicle's dependencies alone.
# Usage, in the checkout: deploy/blueos/layer.sh /opt/incsvr
set -eu
unset PYTHONDONTWRITEBYTECODE
target=$1
python3 -m venv "$target"
# Compiled copies of everything are 70 MB; further down those of what is loaded on a vehicle are made.
"$target/bin/pip" install --quiet --disable-pip-version-check --no-cache-dir --no-compile --constraint constraints.txt . mcap
packages=$("$target/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
find "$packages" -type d \( -name tests -o -name __pycache__ \) -prune -exec rm -rf {} +
# Nothing is installed into the image any more.
rm -rf "$packages"/pip "$packages"/pip-* "$packages"/setuptools* "$packages"/pkg_resources "$packages"/_distutils_hack
rm -f "$packages"/distutils-precedence.pth "$target"/bin/pip*
for command in serve page status; do "$target/bin/incsvr" "$command" --help >/dev/null; done
"$target/bin/python" -c 'import service.config.traced_effects, service.host.host, service.inputs.input_mapper, service.bus.mapped_ingest, mcap.writer'
# What a forecast and the tracer load when they are asked.
"$target/bin/python" -c 'import scipy.linalg, scipy.special'
