"""The asyncio cell and its robots."""

import asyncio
import unittest

import numpy as np
from aprsim import Happens, Refused, TimedOut, Unreachable, aio
from running_cell import PATIENCE, WithCell


class AsyncTest(WithCell):
    def run_async(self, work):
        async def connected():
            async with await aio.Cell.connect(self.daemon.ports_file) as cell:
                return await work(cell)

        return asyncio.run(asyncio.wait_for(connected(), 60 * PATIENCE))

    def test_steps_states_and_refusals(self):
        async def work(cell):
            self.assertTrue(cell.paused)
            after = await cell.step(100)
            self.assertEqual(after.step, 100)
            await cell.save("async")
            first = (await cell.step(50)).state_hash
            await cell.load("async")
            self.assertEqual((await cell.step(50)).state_hash, first)
            await cell.delete_state("async")
            with self.assertRaises(Refused):
                await cell.load("async")
            fault = await cell.inject_fault("belt-jam", duration_s=0.01)
            self.assertEqual((await cell.step(50)).injected_faults[-1].id, fault.id)
            self.assertTrue((await cell.set_conveyor(True)).run)
            await (await cell.robot("fanuc")).take()
            preview = await (await cell.robot("fanuc")).preview_joints([0.1] * 6, mode="avoid")
            self.assertEqual(preview.mode, "avoid")
            await cell.set_planning("fanuc", "check")
            self.assertEqual((await cell.step(1)).robots["fanuc"].planning, "check")
            self.assertGreater(len(await cell.incident()), 1000)

        self.run_async(work)

    def test_a_robot_of_a_paused_cell(self):
        async def work(cell):
            fanuc = await cell.robot("fanuc")
            before = await fanuc.tool()
            await fanuc.move_by([0, 0, -0.05])
            return (await fanuc.tool())[2, 3] - before[2, 3]

        self.assertAlmostEqual(self.run_async(work), -0.05, places=5)

    def test_both_robots_at_once_while_a_stream_looks_on(self):
        async def work(cell):
            robots = [await cell.robot(name) for name in ("fanuc", "motoman")]
            before = [await robot.tool() for robot in robots]
            for robot, tool in zip(robots, before):
                tool = tool.copy()
                tool[2, 3] -= 0.1
                await robot.start(robot.move_command(tool, straight=True))
            together = (await cell.step(50)).robots.values()
            self.assertEqual([robot.moving for robot in together], [True, True])

            async def watch():
                steps = []
                async for snapshot in cell.stream(hz=100, fields=["step"]):
                    steps.append(snapshot.step)
                    if len(set(steps)) == 3:
                        return steps

            await cell.resume()
            _, _, steps = await asyncio.gather(*(robot.wait() for robot in robots), watch())
            self.assertEqual(steps, sorted(steps))
            await cell.pause()
            return [(await robot.tool())[2, 3] - old[2, 3] for robot, old in zip(robots, before)]

        np.testing.assert_allclose(self.run_async(work), -0.1, atol=1e-4)

    def test_nobody_there(self):
        with self.assertRaises(Unreachable):
            asyncio.run(aio.Cell.connect(grpc_port=1))

    def test_close_ends_what_waits(self):
        async def read(stream):
            async for _ in stream:
                pass

        async def work(cell):
            robot = await cell.robot("fanuc")

            async def poll():
                while True:
                    await robot.status()

            await cell.resume()
            readers = [
                asyncio.create_task(waiting)
                for waiting in (
                    read(cell.stream()),
                    read(cell.stream(hz=None, fields=["step"])),
                    read(cell.events()),
                    cell.run_until(Happens(["lost"])),
                    poll(),
                )
            ]
            await cell.snapshot()
            await asyncio.sleep(0)
            await cell.close()
            done, waiting = await asyncio.wait(readers, timeout=30 * PATIENCE)
            self.assertFalse(waiting)
            self.assertEqual([type(reader.exception()) for reader in readers], [Unreachable] * 5)
            with self.assertRaisesRegex(Unreachable, "is closed"):
                await cell.snapshot()
            with self.assertRaisesRegex(Unreachable, "is closed"):
                await anext(aiter(cell.events()))

        self.run_async(work)

    def test_a_cancelled_reader_is_a_cancelled_task(self):
        async def work(cell):
            async def read():
                async for _ in cell.events():
                    pass

            reader = asyncio.create_task(read())
            await cell.snapshot()
            reader.cancel()
            await asyncio.wait([reader], timeout=30 * PATIENCE)
            self.assertTrue(reader.cancelled())
            self.assertEqual((await cell.step(1)).step, 1, "the cell is still open")

        self.run_async(work)

    def test_a_cancelled_run_leaves_the_cell_paused_and_says_so(self):
        async def work(cell):
            await cell.resume()
            run = asyncio.create_task(cell.run_until(Happens(["lost"])))
            await cell.snapshot()
            self.assertFalse(cell.paused)
            run.cancel()
            with self.assertRaises(asyncio.CancelledError):
                await run
            self.assertTrue(cell.paused)
            before = await cell.snapshot()
            self.assertTrue(before.paused)
            await (await cell.robot("fanuc")).dwell(0.1)
            await cell.resume()
            with self.assertRaises(TimedOut):
                await cell.run_until(Happens(["lost"]), timeout_s=0.2)
            self.assertTrue(cell.paused)
            await cell.step(1)

        self.run_async(work)

    def test_connecting_commands_nothing(self):
        async def work(cell):
            step = (await cell.snapshot()).step
            robot = await cell.robot("motoman")
            tool = await robot.tool()
            await robot.take()
            self.assertGreater((await cell.snapshot()).step, step)
            np.testing.assert_allclose(tool, await robot.tool(), atol=1e-5)

        self.run_async(work)


if __name__ == "__main__":
    unittest.main()
