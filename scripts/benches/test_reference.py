"""Whether a gross fall is found, and nothing else."""

import unittest

from benches import reference
from benches.figures import Row, Section

KEPT = {"some": {"speed": 10.0, "cost": 2.0}}


def complaints(speed, cost, kept=KEPT):
    rows = [Row("speed", speed, at_least=20, guarded=True), Row("cost", cost, at_most=2.5, guarded=True)]
    return reference.complaints(Section("some", "", [*rows, Row("free", [0.0])]), kept)


class Complaints(unittest.TestCase):
    def test_noise_is_no_fall_nor_is_an_aim_missed(self):
        self.assertEqual(complaints([5.1, 6.0, 1.0], [3.9, 9.0, 2.0]), [])

    def test_less_than_half_is_named(self):
        self.assertEqual(complaints([4.9, 9.0, 1.0], [2.0]), ["some: speed: 4.9, and it was 10"])

    def test_of_a_cost_it_is_more_than_double(self):
        self.assertEqual(complaints([10.0], [4.1]), ["some: cost: 4.1, and it was 2"])

    def test_what_cannot_fall_to_half_has_another_share(self):
        row = Row("two threads", [0.65], guarded=True, fallen_below=0.7)
        self.assertEqual(len(reference.complaints(Section("some", "", [row]), {"some": {"two threads": 1.0}})), 1)

    def test_a_ratio_that_was_renamed_does_not_go_unseen(self):
        found = complaints([10.0], [2.0], {"some": {"speed": 10.0, "price": 2.0}})
        self.assertEqual(found, ["some: cost: no reference; run scripts/bench", "some: price: not measured any more"])

    def test_the_committed_reference_is_read(self):
        for ratios in reference.read().values():
            self.assertTrue(all(ratio > 0.0 for ratio in ratios.values()))


if __name__ == "__main__":
    unittest.main()
