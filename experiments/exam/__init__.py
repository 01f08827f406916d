"""The exam: blind questions to methods that name what a simulator lacks, and their scores."""
