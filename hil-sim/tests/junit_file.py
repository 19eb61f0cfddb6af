"""Reads a JUnit file with a reader that others wrote, after it has passed the
schema that Jenkins and its kin hold such files to, and prints what is in it.

usage: junit_file.py JUNIT_FILE SCHEMA
"""

import sys

from junitparser import JUnitXml
from lxml import etree

schema = etree.XMLSchema(etree.parse(sys.argv[2]))
schema.assertValid(etree.parse(sys.argv[1]))

for suite in JUnitXml.fromfile(sys.argv[1]):
    properties = {one.name: one.value for one in suite.properties()}
    print(
        f"suite {suite.name} tests={suite.tests} failures={suite.failures} seed={properties['seed']}"
        f" hash={properties['frames_blake3']} {properties['reproduce']}"
    )
    assert suite.tests == len(list(suite))
    for case in suite:
        failures = [f"failed, {one.message} {one.text}" for one in case.result]
        what = " ".join(failures) or "passed"
        print(f"case {case.classname} {case.name}: {' '.join(what.split())}")
