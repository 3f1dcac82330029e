"""Pictures of the cameras as numpy arrays, blocking and by asyncio, and of the environments."""

import asyncio
import unittest
import zlib

import numpy as np
from aprsim import AprsimError, BadArgument, Cell, Daemon, aio, poses
from aprsim.envs import PickEnv
from running_cell import PATIENCE, WithCell

NAMES = ["fanuc_table", "motoman_belt"]


def seen_name(camera, picture, point):
    """Name and depth of what is seen of a point of the world by an undistorted camera, and the pixel;
    no name outside of the picture."""
    X_CW = poses.inverse(camera.X_WC)
    p = X_CW[:3, :3] @ point + X_CW[:3, 3]
    u, v, _ = camera.intrinsics @ (p / p[2])
    x, y = round(float(u)), round(float(v))
    height, width = picture.pixels.shape
    if p[2] <= 0 or not (0 <= x < width and 0 <= y < height):
        return "", p[2], (y, x)
    return picture.objects[picture.pixels[y, x]].name, p[2], (y, x)


def unpacked_png(data):
    """Rows of an 8-bit RGB file whose rows are not filtered (PNG, ISO/IEC 15948)."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed, size = 8, b"", (0, 0)
    while at < len(data):
        length, kind = int.from_bytes(data[at : at + 4], "big"), data[at + 4 : at + 8]
        body = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            size = int.from_bytes(body[:4], "big"), int.from_bytes(body[4:8], "big")
            assert body[8:10] == b"\x08\x02", "8 bits, RGB"
        if kind == b"IDAT":
            packed += body
        at += 12 + length
    width, height = size
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + 3 * width)
    assert not rows[:, 0].any(), "filtered rows"
    return rows[:, 1:].reshape(height, width, 3)


class Pictures(WithCell):
    def test_lists_the_cameras(self):
        self.assertEqual([camera.name for camera in self.cell.cameras()], NAMES)
        with self.assertRaisesRegex(AprsimError, "no camera 'none'; there is fanuc_table, motoman_belt"):
            self.cell.camera("none")

    def test_all_contents_show_the_same_cell(self):
        self.cell.step(200)
        camera = self.cell.camera("fanuc_table")
        self.assertEqual(camera.size, (1280, 720))
        self.assertFalse(camera.distortion.any())
        rgb, depth, depth_16, seen, normals = (
            camera.picture(content)
            for content in ("rgb", "depth", "depth_16", "segmentation", "normals")
        )
        for picture, shape, kind in (
            (rgb, (720, 1280, 3), np.uint8),
            (depth, (720, 1280), np.float32),
            (depth_16, (720, 1280), np.uint16),
            (seen, (720, 1280), np.uint16),
            (normals, (720, 1280, 3), np.float32),
        ):
            self.assertEqual(picture.pixels.shape, shape)
            self.assertEqual(picture.pixels.dtype, kind)
            self.assertEqual(picture.step, 200)
            self.assertAlmostEqual(picture.sim_time_s, 0.2)
        snapshot = self.cell.snapshot(["bodies", "step"])
        visible = 0
        for body in snapshot.bodies.values():
            tray_or_gear = np.asarray(body.position_m) + [0.012, 0.012, 0]  # beside a peg
            name, distance, at = seen_name(camera, seen, tray_or_gear)
            if name != body.name:
                continue
            visible += 1
            self.assertAlmostEqual(depth.pixels[at], distance, delta=0.03)
            self.assertAlmostEqual(depth_16.pixels[at] / 1e4, depth.pixels[at], delta=1e-4)
            self.assertAlmostEqual(float(np.linalg.norm(normals.pixels[at])), 1, places=5)
        self.assertGreater(visible, 5, "bodies are where the snapshot has them")
        kinds = {seen.objects[number].kind for number in np.unique(seen.pixels)}
        self.assertTrue({"body", "robot", "fixed", "belt"} <= kinds, kinds)
        self.assertTrue((unpacked_png(camera.png()) == rgb.pixels).all())
        jpeg = camera.jpeg()
        self.assertEqual((jpeg[:2], jpeg[-2:]), (b"\xff\xd8", b"\xff\xd9"))
        self.assertTrue((camera.rgb() == rgb.pixels).all())
        self.assertTrue((camera.depth() == depth.pixels).all())
        self.assertTrue((camera.segmentation() == seen.pixels).all())
        self.assertTrue((camera.normals() == normals.pixels).all())
        self.assertEqual(camera.objects(), seen.objects)

    def test_a_picture_depends_on_the_state_alone(self):
        camera = self.cell.camera("motoman_belt")
        self.cell.save("begin")
        first = camera.rgb()
        self.cell.set_conveyor(True, speed_m_s=0.2)
        self.cell.step(500)
        later = camera.rgb()
        self.assertTrue((later != first).any())
        self.cell.load("begin")
        self.assertTrue((camera.rgb() == first).all())

    def test_streams(self):
        camera = self.cell.camera("fanuc_table")
        wanted = last = 0
        for picture in camera.stream("segmentation", hz=60):
            self.assertGreaterEqual(picture.step, last)
            last = picture.step
            self.assertLessEqual(last, wanted)  # a picture may show a step in between
            if last == wanted == 30:
                break
            if last == wanted:
                wanted += 10
                self.cell.step(10)

    def test_bad_arguments(self):
        camera = self.cell.camera("fanuc_table")
        with self.assertRaisesRegex(BadArgument, "content"):
            camera.picture("heat")
        with self.assertRaisesRegex(BadArgument, "hz"):
            next(camera.stream(hz=-1))

    def test_asyncio(self):
        async def run():
            cell = await aio.Cell.connect(self.daemon.ports_file)
            try:
                self.assertEqual([camera.name for camera in await cell.cameras()], NAMES)
                camera = await cell.camera("fanuc_table")
                rgb = await camera.rgb()
                self.assertTrue((rgb == self.cell.camera("fanuc_table").rgb()).all())
                self.assertEqual((await camera.depth()).shape, (720, 1280))
                self.assertEqual((await camera.normals()).shape, (720, 1280, 3))
                self.assertTrue((unpacked_png(await camera.png()) == rgb).all())
                self.assertEqual((await camera.jpeg())[:2], b"\xff\xd8")
                objects = await camera.objects()
                numbers = np.unique(await camera.segmentation())
                self.assertLess(numbers.max(), len(objects))
                async for picture in camera.stream("rgb", hz=30):
                    self.assertTrue((picture.pixels == rgb).all())
                    break
            finally:
                await cell.close()

        asyncio.run(run())


class OnAFlange(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(scene="motoman_only", speed="max", start_s=60 * PATIENCE)
        cls.addClassCleanup(cls.daemon.close)

    def test_its_pictures_move_with_the_arm(self):
        with Cell.connect(self.daemon.ports_file) as cell:
            self.assertEqual([camera.name for camera in cell.cameras()], ["motoman_overhead", "motoman_tool"])
            camera = cell.camera("motoman_tool")
            self.assertEqual(camera.carrier, "motoman")
            with self.assertRaisesRegex(AprsimError, "motoman_tool moves with motoman"):
                print(camera.X_WC)
            with self.assertRaisesRegex(AprsimError, "motoman_overhead is fixed"):
                print(cell.camera("motoman_overhead").X_FC)
            cell.pause()
            cell.save("begin")
            first = camera.picture()
            self.assertEqual(first.X_WC.shape, (4, 4))
            overhead = cell.camera("motoman_overhead").picture()
            self.assertTrue((overhead.X_WC == cell.camera("motoman_overhead").X_WC).all())
            cell.resume()
            with cell.robot("motoman") as robot:
                robot.move_joints([0.3, 0.2, 0, 0, 0, 0, 0])
            cell.pause()
            later = camera.picture()
            self.assertGreater(float(np.abs(later.X_WC - first.X_WC).max()), 0.1)
            self.assertTrue((later.pixels != first.pixels).any())
            cell.load("begin")
            again = camera.picture()
            self.assertTrue((again.pixels == first.pixels).all(), "the same state, the same bits")
            self.assertTrue((again.X_WC == first.X_WC).all())


class Environments(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(scene="aprs", speed="stepped", start_s=60 * PATIENCE)
        cls.addClassCleanup(cls.daemon.close)

    def test_render_what_the_robots_camera_sees(self):
        with Cell.connect(self.daemon.ports_file) as cell:
            env = PickEnv(cell, render_mode="rgb_array")
            self.addCleanup(env.close)
            self.assertEqual(env.metadata["render_modes"], ["rgb_array"])
            env.reset(seed=1)
            first = env.render()
            self.assertEqual(first.shape, (720, 1280, 3))
            self.assertTrue((first == cell.camera("fanuc_table").rgb()).all())
            env.step([1, 0, 0, 0, 1])
            self.assertTrue((env.render() != first).any())
            env.reset(seed=1)
            self.assertTrue((env.render() == first).all(), "the same seed, the same picture")
            other = PickEnv(cell, render_mode="rgb_array", camera="motoman_belt")
            self.addCleanup(other.close)
            other.reset(seed=1)
            self.assertTrue((other.render() == cell.camera("motoman_belt").rgb()).all())

    def test_pictures_as_observations(self):
        with Cell.connect(self.daemon.ports_file) as cell:
            env = PickEnv(cell, observation="rgb", image_scale=8)
            self.addCleanup(env.close)
            first, info = env.reset(seed=1)
            self.assertEqual((first.shape, first.dtype), ((90, 160, 3), np.uint8))
            self.assertIn(first, env.observation_space)
            sample = env.observation_space.sample()
            self.assertIn(sample, env.observation_space)
            self.assertNotIn(sample.astype(float), env.observation_space)
            self.assertEqual(len(info["state"]), len(env.observation_names))
            whole = cell.camera("fanuc_table").rgb()
            mean = whole[8:16, 16:24].reshape(64, 3).mean(axis=0).round()
            self.assertTrue((first[1, 2] == mean).all())
            after, reward, _, _, info = env.step([1, 0, 0, 0, 1])
            self.assertTrue((after != first).any())
            again, _ = env.reset(seed=1)
            self.assertTrue((again == first).all(), "the same seed, the same picture")
            other = PickEnv(cell)
            self.addCleanup(other.close)
            state, _ = other.reset(seed=1)
            self.assertEqual(state.shape, (len(env.observation_names),))
            with self.assertRaisesRegex(BadArgument, "observation"):
                PickEnv(cell, observation="depth")
            with self.assertRaisesRegex(BadArgument, "image_scale"):
                PickEnv(cell, observation="rgb", image_scale=0)

    def test_render_nothing_by_default(self):
        with Cell.connect(self.daemon.ports_file) as cell:
            env = PickEnv(cell)
            self.addCleanup(env.close)
            env.reset(seed=1)
            self.assertIsNone(env.render())
            with self.assertRaisesRegex(BadArgument, "render_mode"):
                PickEnv(cell, render_mode="human")
            with self.assertRaisesRegex(AprsimError, "no camera 'none'"):
                PickEnv(cell, render_mode="rgb_array", camera="none")


if __name__ == "__main__":
    unittest.main()
