import threading

import pytest

from reconstruct.viewer.worker import Failed, Worker

PATIENCE = 240


@pytest.fixture
def worker():
    made = Worker("test")
    yield made
    made.close()


def all_of(worker, count):
    """So many results, waited for."""
    found = []
    end = threading.Event()
    for _ in range(PATIENCE * 200):
        found += worker.take()
        if len(found) >= count:
            return found
        end.wait(0.005)
    pytest.fail(f"only {found}")


def test_the_newest_job_wins_and_a_begun_step_is_handed_over(worker):
    started, go_on = threading.Event(), threading.Event()
    done = []

    def long():
        started.set()
        go_on.wait(PATIENCE)
        yield "first step"
        done.append("second step")
        yield "second step"

    worker.ask(long)
    assert started.wait(PATIENCE) and worker.busy
    worker.ask(lambda: iter(["never asked for"]))
    worker.ask(lambda: iter(["newest"]))
    go_on.set()
    assert all_of(worker, 2) == ["first step", "newest"]
    assert not done and not worker.take()


def test_what_a_job_raises_becomes_a_message_and_the_next_job_is_done(worker):
    def bad():
        yield 1
        raise OSError("frame_0003.tif is\nmissing")

    worker.ask(bad)
    one, failed = all_of(worker, 2)
    assert one == 1 and isinstance(failed, Failed)
    assert failed.message == "frame_0003.tif is missing"
    worker.ask(lambda: iter([2]))
    assert all_of(worker, 1) == [2]


def test_a_job_is_left_between_steps_and_its_generator_is_closed(worker):
    started, go_on, closed = threading.Event(), threading.Event(), threading.Event()

    def long():
        try:
            started.set()
            go_on.wait(PATIENCE)
            yield None
            yield "too far"
        finally:
            closed.set()

    worker.ask(long)
    assert started.wait(PATIENCE)
    worker.leave()
    assert not worker.busy
    go_on.set()
    assert closed.wait(PATIENCE)
    assert worker.take() == []


def test_who_waits_is_woken_for_every_result():
    woken = threading.Semaphore(0)
    worker = Worker("test", woken.release)
    worker.ask(lambda: iter([1, 2]))
    for _ in range(3):  # two results and the end
        assert woken.acquire(timeout=PATIENCE)
    assert worker.take() == [1, 2] and not worker.busy
    worker.close()
