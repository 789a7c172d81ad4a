r"""How different eccentricity layers look from the reference to FovVideoVDP (Mantiuk et al. 2021), by quality index j.

    apt-get install python3-torch python3-venv          (a torch without CUDA)
    /usr/bin/python3 -m venv --system-site-packages venv && \
        venv/bin/pip install --no-deps pyfvvdp==1.2.2 && \
        venv/bin/pip install pillow "numpy<2" "scipy<1.14" imageio ffmpeg-python
    venv/bin/python fovvideovdp_peer.py ../../target/release/parafovea SCENE [SCENE ...]

The program renders each scene at 960 x 540 pixels on Guenter's display (51 cm wide at 59 cm) with the gaze off the middle,
once in full and once at each j; several frames, so that what is remembered has settled, of a camera that stands still. The
judge is told the display's geometry, its peak (here 200 cd/m2) and where the eye looks. It answers in just objectionable
differences: 10 is no difference, less is worse. Prints one line a scene, and whether the order is that of j.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pyfvvdp
import torch
from PIL import Image

INDICES = [4, 7, 10, 12, 15, 18, 22]
SIZE = (960, 540)
WIDTH_M, DISTANCE_M, PEAK = 0.51, 0.59, 200.0
GAZE_DEG = (4.0, -2.0)


def render(program, scene, renderer, settings, file):
    command = [program, "render", "--scene", scene, "--renderer", renderer, "--display", "guenter-2012",
               "--size", f"{SIZE[0]}x{SIZE[1]}", f"--gaze={GAZE_DEG[0]},{GAZE_DEG[1]}", "--time", "0.5",
               "--frames", "12", "--fps", "60", "--out", str(file), "--json"]
    for name, value in settings:
        command += ["--set", f"{name}={value}"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    picture = np.asarray(Image.open(file).convert("RGB"), dtype=np.float32) / 255
    return picture, json.loads(done.stdout)


def main():
    program, scenes = sys.argv[1], sys.argv[2:]
    geometry = pyfvvdp.fvvdp_display_geometry(SIZE, distance_m=DISTANCE_M,
                                              diagonal_size_inches=WIDTH_M * np.hypot(1, SIZE[1] / SIZE[0]) / 0.0254)
    photometry = pyfvvdp.fvvdp_display_photo_eotf(PEAK, contrast=1000, EOTF="sRGB", E_ambient=0)
    judge = pyfvvdp.fvvdp(display_geometry=geometry, display_photometry=photometry, foveated=True, device=torch.device("cpu"))
    pitch_m = WIDTH_M / SIZE[0]
    fixation = torch.tensor([SIZE[0] / 2 + DISTANCE_M * np.tan(np.radians(GAZE_DEG[0])) / pitch_m,
                             SIZE[1] / 2 - DISTANCE_M * np.tan(np.radians(GAZE_DEG[1])) / pitch_m])
    print(f"pyfvvdp {pyfvvdp.__version__ if hasattr(pyfvvdp, '__version__') else ''} torch {torch.__version__} "
          f"{geometry.get_ppd():.2f} px/deg, fixation {fixation.numpy().round(1).tolist()}")
    monotone = True
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "picture.png"
        for scene in scenes:
            still = [("scene.camera", "static")]
            try:
                reference, _ = render(program, scene, "reference", still, file)
            except subprocess.CalledProcessError:
                still = []
                reference, _ = render(program, scene, "reference", still, file)
            answers = []
            for index in INDICES:
                test, _ = render(program, scene, "layers", still + [("quality_index", index)], file)
                jod, _ = judge.predict(test, reference, dim_order="HWC", fixation_point=fixation)
                answers.append(float(jod))
            rising = all(a < b for a, b in zip(answers, answers[1:]))
            monotone = monotone and rising
            line = "  ".join(f"{index}: {jod:.3f}" for index, jod in zip(INDICES, answers))
            print(f"{scene:14} {line}  {'rising' if rising else 'NOT RISING'}", flush=True)
    sys.exit(0 if monotone else 1)


if __name__ == "__main__":
    main()
