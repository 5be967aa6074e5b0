"""A domain is given to one process at a time, and only if no participant listens in it."""

from __future__ import annotations

import subprocess
import sys

import rclpy

from friction_runtime.domain import free_domain_id, is_free

CHOOSE = """
import os, sys
from friction_runtime.domain import free_domain_id
os.getpid = lambda: 7  # all begin their search at the same place
sys.stdin.readline()
print(free_domain_id(), flush=True)
sys.stdin.read()
"""


def test_processes_that_choose_at_the_same_moment_get_different_domains() -> None:
    command = [sys.executable, "-c", CHOOSE]
    processes = [subprocess.Popen(command, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE) for _ in range(5)]
    chosen = []
    for process in processes:
        assert process.stdin is not None
        process.stdin.write("now\n")
        process.stdin.flush()
    for process in processes:
        assert process.stdout is not None
        chosen.append(int(process.stdout.readline()))
    for process in processes:
        process.communicate()
    assert len(set(chosen)) == len(processes)


def test_domain_is_in_use_while_a_participant_listens_over_loopback_alone() -> None:
    found = free_domain_id()
    assert 1 <= found <= 101
    assert is_free(found)
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=found)
    node = rclpy.create_node("participant", context=context)
    assert not is_free(found)
    node.destroy_node()
    rclpy.shutdown(context=context)
    assert is_free(found)
    assert free_domain_id() != found
