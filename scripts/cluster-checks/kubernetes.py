"""The Kubernetes manifest of scripts/cluster: held to Kubernetes' schemas and to what they
cannot say, and what its pods would run, run here."""

import concurrent.futures
import copy
import os
import subprocess

import kubernetes_validate
import yaml

from bench import EXAMPLES, LIMIT_S, Failed

MANIFEST = EXAMPLES / "sweep-job.yaml"
OLDEST = "1.29"


def documents():
    return list(yaml.safe_load_all(MANIFEST.read_text()))


def of_kind(manifest, kind):
    return next(document for document in manifest if document["kind"] == kind)


def newest():
    return kubernetes_validate.latest_version()


def problems(manifest, version):
    """What an API server of that version, or the job, would make of it."""
    for document in manifest:
        try:
            kubernetes_validate.validate(document, version, strict=True)
        except kubernetes_validate.ValidationError as error:
            place = ".".join(map(str, error.path))
            yield f"{document['kind']} {place}: {error.message}"
            return
    job = of_kind(manifest, "Job")["spec"]
    pod = job["template"]["spec"]
    container = pod["containers"][0]
    told = {variable["name"]: variable["value"] for variable in container["env"]}.get("JOB_COMPLETIONS")
    if told != str(job["completions"]):
        yield f"found JOB_COMPLETIONS={told}, expected completions={job['completions']}"
    if job["completionMode"] != "Indexed":
        yield f"found completionMode {job['completionMode']}, expected Indexed, which gives each pod its part"
    if pod["restartPolicy"] != "Never":
        yield f"found restartPolicy {pod['restartPolicy']}, expected Never, as backoffLimitPerIndex wants it"
    known = {document["metadata"]["name"] for document in manifest}
    sources = {volume["name"]: volume.get("configMap", {}).get("name") or volume["persistentVolumeClaim"]["claimName"]
               for volume in pod["volumes"]}
    for name, source in sources.items():
        if source not in known:
            yield f"found volume {name} of {source}, expected one of {', '.join(sorted(known))}"
    for mount in container["volumeMounts"]:
        if mount["name"] not in sources:
            yield f"found a mount of {mount['name']}, expected one of {', '.join(sources)}"


def is_valid():
    for version in (OLDEST, newest()):
        for problem in problems(documents(), version):
            raise Failed(f"{MANIFEST.name}, Kubernetes {version}: {problem}")


def mistakes_are_found():
    def job(change):
        manifest = copy.deepcopy(documents())
        change(of_kind(manifest, "Job")["spec"])
        return manifest

    def container(spec):
        return spec["template"]["spec"]["containers"][0]

    mistakes = {
        "JOB_COMPLETIONS": job(lambda spec: spec.update(completions=9)),
        "value": job(lambda spec: container(spec)["env"][0].update(value=8)),
        "completionmode": job(lambda spec: spec.update(completionmode="Indexed")),
        "restartPolicy": job(lambda spec: spec["template"]["spec"].update(restartPolicy="OnFailure")),
        "mount of plans": job(lambda spec: container(spec)["volumeMounts"][0].update(name="plans")),
    }
    for says, manifest in mistakes.items():
        found = list(problems(manifest, newest()))
        if not any(says in problem for problem in found):
            raise Failed(f"found {found or 'nothing'} wrong with a manifest, expected a word of {says}")


def plan():
    return of_kind(documents(), "ConfigMap")["data"]["plan.toml"]


class Pods:
    """What the job's controller does with an indexed job, as processes."""

    def sweep(self, sweep):
        job = of_kind(documents(), "Job")["spec"]
        here = self._mounts(sweep, job["template"]["spec"]["containers"][0])
        (here["/plan"] / "plan.toml").write_text(sweep.plan)
        with concurrent.futures.ThreadPoolExecutor(job["parallelism"]) as pool:
            said = list(pool.map(lambda index: self._index(sweep, here, job, index), range(job["completions"])))
        sweep.merge(sorted((here["/results"] / "sweeps").iterdir()))
        return "".join(said)

    def _index(self, sweep, here, job, index):
        container = job["template"]["spec"]["containers"][0]
        command = [sweep.hil_sim, *(self._placed(argument, here) for argument in container["args"])]
        variables = {variable["name"]: variable["value"] for variable in container["env"]}
        environment = {**os.environ, **variables, "JOB_COMPLETION_INDEX": str(index)}
        folder = self._placed(container["workingDir"], here)
        said = ""
        for _ in range(1 + job["backoffLimitPerIndex"]):
            pod = subprocess.run(
                command, cwd=folder, env=environment, text=True, timeout=LIMIT_S, stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            )
            said += pod.stdout
            if pod.returncode == 0:
                return said
        raise Failed(f"index {index}: exit status {pod.returncode}\n{said}")

    def _mounts(self, sweep, container):
        here = {mount["mountPath"]: sweep.folder / mount["name"] for mount in container["volumeMounts"]}
        for folder in here.values():
            folder.mkdir(exist_ok=True)
        return here

    def _placed(self, path, here):
        for mounted, folder in here.items():
            if path.startswith(mounted):
                return f"{folder}{path.removeprefix(mounted)}"
        return path
