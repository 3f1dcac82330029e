"""Both robots at once, with asyncio, while a stream looks on."""

import asyncio

from aprsim import aio


async def main() -> None:
    async with await aio.Cell.connect() as cell:
        robots = [await cell.robot(name) for name in ("fanuc", "motoman")]
        highest = {robot.name: 0.0 for robot in robots}

        async def watch() -> None:
            async for snapshot in cell.stream(hz=50, fields=["robots"]):
                for name in highest:
                    height = float(snapshot.robot(name).tool_in_world[2, 3])
                    highest[name] = max(highest[name], height)

        watching = asyncio.create_task(watch())
        await asyncio.gather(*(robot.move_by([0, 0, 0.03]) for robot in robots))
        await asyncio.gather(*(robot.move_by([0, 0, -0.03]) for robot in robots))
        watching.cancel()
        await asyncio.gather(watching, return_exceptions=True)
        print({name: round(height, 3) for name, height in highest.items()})


asyncio.run(main())
