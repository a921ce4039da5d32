"""A slow line that loses connections, for tests: relays TCP between two ports of this machine.

usage: slow_line.py PORT TO_PORT DELAY_MS CUT_EVERY
Every piece of up to 16 KiB arrives DELAY_MS later, either way. Of the pieces that the server sends each CUT_EVERYth is cut in half
and its connection with it. On SIGTERM prints how many pieces came and how many connections were cut.
"""
import asyncio
import signal
import sys

PIECE = 16384


async def relay(reader, writer, delay_s, cut):
    loop = asyncio.get_running_loop()
    under_way = asyncio.Queue()

    async def deliver():
        while (item := await under_way.get()) is not None:
            due, data = item
            await asyncio.sleep(max(0, due - loop.time()))
            if cut and cut():
                writer.write(data[: len(data) // 2])
                await writer.drain()
                return
            writer.write(data)
            await writer.drain()

    async def take():
        while data := await reader.read(PIECE):
            under_way.put_nowait((loop.time() + delay_s, data))
        under_way.put_nowait(None)

    taking = asyncio.create_task(take())
    try:
        await deliver()
    finally:
        taking.cancel()
        writer.close()


async def main(port, to_port, delay_ms, cut_every):
    pieces = cuts = 0

    def cut():
        nonlocal pieces, cuts
        pieces += 1
        cuts += pieces % cut_every == 0
        return pieces % cut_every == 0

    async def serve(reader, writer):
        up_reader, up_writer = await asyncio.open_connection("127.0.0.1", to_port)
        await asyncio.gather(
            relay(reader, up_writer, delay_ms / 1000, None),
            relay(up_reader, writer, delay_ms / 1000, cut),
            return_exceptions=True,
        )

    server = await asyncio.start_server(serve, "127.0.0.1", port)
    stop = asyncio.Event()
    asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, stop.set)
    async with server:
        await stop.wait()
    print(f"{pieces} pieces, {cuts} connections cut", flush=True)


asyncio.run(main(*map(int, sys.argv[1:5])))
